#include "colmap_plugin/evaluation/cloud_metrics.h"

#include <gtest/gtest.h>

namespace structnerf {
namespace {

// Far from the origin, as geo-referenced models are.
const Eigen::Vector3d kOrigin(4e5, 5e6, 100);

std::vector<Eigen::Vector3d> Grid(const int num_points,
                                  const Eigen::Vector3d& shift) {
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < num_points; ++i) {
    points.push_back(kOrigin + shift +
                     Eigen::Vector3d(0.5 * (i % 20), 0.5 * (i / 20), 0));
  }
  return points;
}

TEST(CompareCloudsTest, EqualCloudsArePerfect) {
  const auto cloud = Grid(400, Eigen::Vector3d::Zero());
  const CloudMetrics metrics = CompareClouds(cloud, cloud);
  EXPECT_EQ(metrics.accuracy_mean, 0);
  EXPECT_EQ(metrics.completeness_mean, 0);
  for (const double f_score : metrics.f_score) {
    EXPECT_EQ(f_score, 1);
  }
}

TEST(CompareCloudsTest, AKnownShiftGivesItself) {
  const auto truth = Grid(400, Eigen::Vector3d::Zero());
  const auto predicted = Grid(200, {0, 0, 0.07});
  const CloudMetrics metrics = CompareClouds(predicted, truth);
  EXPECT_EQ(metrics.num_predicted_points, 200);
  EXPECT_EQ(metrics.num_true_points, 400);
  EXPECT_NEAR(metrics.accuracy_mean, 0.07, 1e-6);
  EXPECT_NEAR(metrics.accuracy_median, 0.07, 1e-6);
  EXPECT_EQ(metrics.precision[1], 0);
  EXPECT_EQ(metrics.precision[2], 1);
  // The other half of the truth is 0.5 and more away, most of it beyond the
  // cap of one metre.
  EXPECT_DOUBLE_EQ(metrics.recall[2], 0.5);
  EXPECT_DOUBLE_EQ(metrics.f_score[2], 2 * 0.5 / 1.5);
  EXPECT_LE(metrics.completeness_mean, (200 * 0.07 + 200 * 1) / 400 + 1e-6);
  EXPECT_GT(metrics.completeness_mean, (200 * 0.07 + 180 * 1) / 400);
}

TEST(CompareCloudsTest, AnEmptyCloudScoresNothing) {
  const auto truth = Grid(10, Eigen::Vector3d::Zero());
  for (const CloudMetrics& metrics :
       {CompareClouds({}, truth), CompareClouds(truth, {})}) {
    EXPECT_EQ(metrics.f_score[2], 0);
    EXPECT_EQ(metrics.recall[2], 0);
  }
}

}  // namespace
}  // namespace structnerf
