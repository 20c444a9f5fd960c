// Many runs side by side.

#include "tests/end_to_end/json_files.h"
#include "tests/end_to_end/resumed_run.h"

#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace structnerf {
namespace {

using LoadTest = ResumedRunTest;

#ifdef __SANITIZE_ADDRESS__  // which takes half a gigabyte itself
constexpr char kMemoryLimit[] = "--StructNeRF.max_memory_gb=2";
#else
constexpr char kMemoryLimit[] = "--StructNeRF.max_memory_gb=0.5";
#endif

TEST_F(LoadTest, TenRunsSideBySideWithinTheirMemoryLimits) {
  constexpr int kNumRuns = 10;
  std::vector<std::unique_ptr<Program>> programs;
  for (int run = 0; run < kNumRuns; ++run) {
    programs.push_back(std::make_unique<Program>(
        Command({kMemoryLimit}, "run" + std::to_string(run))));
  }
  for (int run = 0; run < kNumRuns; ++run) {
    SCOPED_TRACE(run);
    const std::string output = "run" + std::to_string(run);
    const ProgramResult result = programs[run]->Wait();
    ASSERT_EQ(result.exit_code, 0) << result.error;
    EXPECT_TRUE(ReadResult(output) == expected_);
    const auto memory = ReadReport(temp_dir_ / output)["memory"];
    EXPECT_LE(memory["peak_bytes"].get<size_t>(),
              memory["limit_bytes"].get<size_t>());
  }
}

}  // namespace
}  // namespace structnerf
