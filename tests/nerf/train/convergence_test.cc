#include "nerf/train/convergence.h"

#include <cmath>

#include <gtest/gtest.h>

namespace structnerf {
namespace {

TEST(ConvergenceMonitor, TwoMeasurementsWithoutChangeAreNeeded) {
  ConvergenceMonitor monitor;
  EXPECT_FALSE(monitor.Measure(0.01, {1, 2, 3}));
  EXPECT_FALSE(monitor.Measure(0.01, {1, 2, 3}));
  EXPECT_TRUE(monitor.Measure(0.0099, {1.001f, 2, 3}));
}

TEST(ConvergenceMonitor, FallingErrorIsChange) {
  ConvergenceMonitor monitor;
  double error = 0.01;
  for (int i = 0; i < 10; ++i) {
    EXPECT_FALSE(monitor.Measure(error, {1, 2, 3}));
    error *= 0.99 - ConvergenceMonitor::kMinErrorFall;
  }
}

TEST(ConvergenceMonitor, MovingDepthIsChange) {
  ConvergenceMonitor monitor;
  float depth = 1;
  for (int i = 0; i < 10; ++i) {
    // One of three pixels may do what it likes.
    EXPECT_FALSE(monitor.Measure(0.01, {depth, 2 * depth, 3}));
    depth *= 1.001f + static_cast<float>(ConvergenceMonitor::kMaxDepthChange);
  }
  depth = 1;
  monitor = ConvergenceMonitor();
  monitor.Measure(0.01, {depth, 2, 3});
  monitor.Measure(0.01, {1.1f * depth, 2, 3});
  EXPECT_TRUE(monitor.Measure(0.01, {1.2f * depth, 2, 3}));
}

TEST(ConvergenceMonitor, ARestInBetweenIsForgotten) {
  ConvergenceMonitor monitor;
  monitor.Measure(0.01, {1, 2, 3});
  EXPECT_FALSE(monitor.Measure(0.01, {1, 2, 3}));
  EXPECT_FALSE(monitor.Measure(0.005, {1, 2, 3}));
  EXPECT_FALSE(monitor.Measure(0.005, {1, 2, 3}));
  EXPECT_TRUE(monitor.Measure(0.005, {1, 2, 3}));
}

TEST(ConvergenceMonitor, UnknownDepthIsChange) {
  ConvergenceMonitor monitor;
  for (int i = 0; i < 5; ++i) {
    EXPECT_FALSE(monitor.Measure(0.01, {NAN, NAN, NAN}));
  }
}

}  // namespace
}  // namespace structnerf
