#include "tests/benchmarks/roofline_probe.h"

#include <gtest/gtest.h>

namespace structnerf {
namespace {

// Bounds that every machine keeps and a broken probe does not: a loop that was
// optimised away is orders of magnitude too fast.
TEST(RooflineProbe, IsPlausible) {
  const RooflineProbe probe(1);
  const double clock = probe.ClockRate();
  EXPECT_GT(clock, 0.3e9);
  EXPECT_LT(clock, 12e9);
  EXPECT_GT(probe.PeakFlops(), 0.5 * clock);
  EXPECT_LT(probe.PeakFlops(), 200 * clock);
  const double near = probe.RandomLineRate(size_t{64} << 10);
  const double far = probe.RandomLineRate(size_t{128} << 20);
  EXPECT_LT(near, 8 * clock);
  EXPECT_GT(near, 1.2 * far);
  EXPECT_GT(far, 1e6);
  EXPECT_GT(probe.StreamBandwidth(), 1e8);
  EXPECT_LT(probe.StreamBandwidth(), 200 * clock);
}

TEST(RooflineProbe, NamesTheInstructionSet) {
  EXPECT_STRNE(SimdTargetInUse(), "");
}

}  // namespace
}  // namespace structnerf
