// Takes always the same training steps, on one thread and with AVX2 even if the
// machine has more, for instruction_count_test to count what they cost.

#include "tests/benchmarks/trained_room.h"

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>

#include <hwy/highway.h>

// Highway's library times the timer when it is loaded, with an instruction that
// valgrind does not know on some machines. Nothing here needs it.
namespace hwy {
namespace platform {
uint64_t TimerResolution() { return 1; }
}  // namespace platform
}  // namespace hwy

namespace structnerf {
namespace {

constexpr int kNumRays = 64;

// The density cache is refreshed within the steps that follow.
constexpr int kWarmUpSteps = 14;
constexpr int kNumSteps = 4;

EngineOptions SmallOptions() {
  EngineOptions options = PresetEngineOptions("medium", 1);
  options.field.log2_table_size = 13;
  options.sampling.cache_resolution = 16;
  return options;
}

}  // namespace

// What is counted.
__attribute__((noinline)) double MeasuredSteps(TrainedRoom* room) {
  return room->Train(kNumSteps);
}

}  // namespace structnerf

int main() {
  hwy::SetSupportedTargetsForTest(HWY_AVX2);
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  structnerf::TrainedRoom room(
      structnerf::MakeFusedEngine(structnerf::SmallOptions()),
      structnerf::kNumRays);
  room.Train(structnerf::kWarmUpSteps);
  const double loss = structnerf::MeasuredSteps(&room);
  std::printf("%.6g\n", loss);
  return std::isfinite(loss) ? EXIT_SUCCESS : EXIT_FAILURE;
}
