#include "nerf/engine/machine_speed.h"

#include <algorithm>
#include <cmath>
#include <thread>

#include <gtest/gtest.h>

namespace structnerf {
namespace {

TEST(MachineSpeed, IsThatOfAMachine) {
  for (const int num_threads : {1, -1}) {
    const double slowness = MeasureSlowness(num_threads);
    EXPECT_TRUE(std::isfinite(slowness));
    // Between a machine ten times as fast and one hundred times as slow.
    EXPECT_GT(slowness, 0.1);
    EXPECT_LT(slowness, 100);
  }
}

// More threads than cores share the cores; each then gets less done.
TEST(MachineSpeed, CrowdedCoresAreSlow) {
  const int num_cores =
      std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  EXPECT_GT(MeasureSlowness(8 * num_cores), 1.5 * MeasureSlowness(1));
}

}  // namespace
}  // namespace structnerf
