// Guards the speed of the training step without a clock: counts instructions
// under valgrind. Only for the compiler and the options the figure belongs to.

#include "tests/support/temp_dir.h"

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <string>

#include <gtest/gtest.h>
#include <hwy/highway.h>

namespace structnerf {
namespace {

// Million instructions of fixed_step's MeasuredSteps, g++ 12, release. Whoever
// changes a kernel on purpose sets the new figure.
constexpr double kExpectedMillions = 60.12;
constexpr double kTolerance = 0.05;

TEST(InstructionCount, TrainingStepCostsWhatItDid) {
#if !defined(NDEBUG) || defined(__clang__) || __GNUC__ != 12
  GTEST_SKIP() << "the figure is for g++ 12 and a release build";
#endif
  if ((hwy::SupportedTargets() & HWY_AVX2) == 0) {
    GTEST_SKIP() << "the figure is for AVX2";
  }
  const TempDir folder;
  const std::string counts = folder / "counts";
  const std::string command =
      "'" STRUCTNERF_VALGRIND "' --tool=callgrind --callgrind-out-file='" +
      counts + "' --toggle-collect='structnerf::MeasuredSteps*' '" +
      STRUCTNERF_FIXED_STEP "' > '" + (folder / "log") + "' 2>&1";
  ASSERT_EQ(std::system(command.c_str()), 0) << command;
  std::ifstream file(counts);
  std::string word;
  double instructions = 0;
  while (file >> word) {
    if (word == "summary:") {
      file >> instructions;
    }
  }
  const double millions = 1e-6 * instructions;
  RecordProperty("million_instructions", std::to_string(millions));
  EXPECT_NEAR(millions, kExpectedMillions, kTolerance * kExpectedMillions);
}

}  // namespace
}  // namespace structnerf
