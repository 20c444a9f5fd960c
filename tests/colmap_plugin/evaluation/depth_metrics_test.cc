#include "colmap_plugin/evaluation/depth_metrics.h"

#include "nerf/util/median.h"

#include <cmath>

#include <gtest/gtest.h>

namespace structnerf {
namespace {

TEST(DepthErrorsTest, KnownErrorsGiveKnownMetrics) {
  DepthErrors errors;
  errors.Add(1, 1.01f);
  errors.Add(2, 1.96f);
  errors.Add(4, 4.08f);
  errors.Add(2, 3);
  errors.Add(2, 0);  // missing
  const DepthMetrics metrics = errors.Compute();
  EXPECT_EQ(metrics.num_pixels, 5);
  EXPECT_EQ(metrics.num_predictions, 4);
  EXPECT_DOUBLE_EQ(metrics.completeness, 0.8);
  EXPECT_NEAR(metrics.rmse,
              std::sqrt((0.01 * 0.01 + 0.04 * 0.04 + 0.08 * 0.08 + 1) / 4),
              1e-6);
  EXPECT_NEAR(metrics.median_error, 0.06, 1e-6);
  EXPECT_NEAR(metrics.abs_rel, (0.01 + 0.02 + 0.02 + 0.5) / 4, 1e-6);
  EXPECT_DOUBLE_EQ(metrics.delta[0], 0.75);
  EXPECT_DOUBLE_EQ(metrics.delta[1], 1);
  // Of all pixels, the missing one included.
  EXPECT_DOUBLE_EQ(metrics.within[0], 0.2);
  EXPECT_DOUBLE_EQ(metrics.within[1], 0.4);
  EXPECT_DOUBLE_EQ(metrics.within[2], 0.6);
}

TEST(DepthErrorsTest, AnErrorOfTheThresholdCountsAsWithin) {
  DepthErrors errors;
  errors.Add(1, 1.02f);
  errors.Add(2, 1.95f);
  errors.Add(3, 3.1f);
  const DepthMetrics metrics = errors.Compute();
  EXPECT_DOUBLE_EQ(metrics.within[0], 1.0 / 3);
  EXPECT_DOUBLE_EQ(metrics.within[1], 2.0 / 3);
  EXPECT_DOUBLE_EQ(metrics.within[2], 1);
}

TEST(DepthErrorsTest, NothingPredictedIsNotPerfect) {
  DepthErrors errors;
  errors.Add(1, 0);
  const DepthMetrics metrics = errors.Compute();
  EXPECT_EQ(metrics.num_predictions, 0);
  EXPECT_EQ(metrics.completeness, 0);
  EXPECT_EQ(metrics.within[2], 0);
}

TEST(MedianTest, IsTheMiddleOrTheMeanOfTheMiddleTwo) {
  std::vector<float> odd = {5, 1, 3};
  EXPECT_EQ(Median(&odd), 3);
  std::vector<double> even = {4, 1, 3, 10};
  EXPECT_EQ(Median(&even), 3.5);
  std::vector<double> none;
  EXPECT_EQ(Median(&none), 0);
}

}  // namespace
}  // namespace structnerf
