#include "nerf/engine/machine_speed.h"

#include <cmath>

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
  EXPECT_GT(MeasureSlowness(64), 1.5 * MeasureSlowness(1));
}

}  // namespace
}  // namespace structnerf
