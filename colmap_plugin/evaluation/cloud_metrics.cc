#include "colmap_plugin/evaluation/cloud_metrics.h"

#include "nerf/util/median.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <opencv2/core.hpp>
#include <opencv2/flann.hpp>

namespace structnerf {
namespace {

constexpr double kMaxDistance = 1.0;
constexpr int kMaxLeafSize = 16;

// Single precision relative to a point of the scene, since models may lie far
// from the origin.
cv::Mat1f PointMatrix(const std::vector<Eigen::Vector3d>& points,
                      const Eigen::Vector3d& origin) {
  cv::Mat1f matrix(static_cast<int>(points.size()), 3);
  for (size_t i = 0; i < points.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      matrix(static_cast<int>(i), axis) =
          static_cast<float>(points[i][axis] - origin[axis]);
    }
  }
  return matrix;
}

// Distance of every query to its nearest point, at most kMaxDistance.
std::vector<double> NearestDistances(const cv::Mat1f& queries,
                                     const cv::Mat1f& points) {
  cv::flann::GenericIndex<cvflann::L2_Simple<float>> index(
      points, cvflann::KDTreeSingleIndexParams(kMaxLeafSize));
  std::vector<double> distances(queries.rows);
  cv::parallel_for_({0, queries.rows}, [&](const cv::Range& range) {
    cv::Mat1i neighbors(1, 1);
    cv::Mat1f squares(1, 1);
    for (int i = range.start; i < range.end; ++i) {
      const cv::Mat1f query = queries.row(i);
      index.knnSearch(query, neighbors, squares, 1, cvflann::SearchParams());
      distances[i] =
          std::min(kMaxDistance, std::sqrt(static_cast<double>(squares(0, 0))));
    }
  });
  return distances;
}

double Mean(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / values.size();
}

double ShareWithin(const std::vector<double>& distances,
                   const double threshold) {
  return static_cast<double>(std::count_if(distances.begin(),
                                           distances.end(),
                                           [&](const double distance) {
                                             return distance <
                                                    threshold + kThresholdSlack;
                                           })) /
         distances.size();
}

}  // namespace

CloudMetrics CompareClouds(const std::vector<Eigen::Vector3d>& predicted,
                           const std::vector<Eigen::Vector3d>& truth) {
  CloudMetrics metrics;
  metrics.num_predicted_points = predicted.size();
  metrics.num_true_points = truth.size();
  if (predicted.empty() || truth.empty()) {
    return metrics;
  }
  const Eigen::Vector3d& origin = truth.front();
  const cv::Mat1f predicted_points = PointMatrix(predicted, origin);
  const cv::Mat1f true_points = PointMatrix(truth, origin);
  std::vector<double> accuracy =
      NearestDistances(predicted_points, true_points);
  std::vector<double> completeness =
      NearestDistances(true_points, predicted_points);
  metrics.accuracy_mean = Mean(accuracy);
  metrics.completeness_mean = Mean(completeness);
  for (size_t i = 0; i < kErrorThresholds.size(); ++i) {
    const double precision = ShareWithin(accuracy, kErrorThresholds[i]);
    const double recall = ShareWithin(completeness, kErrorThresholds[i]);
    metrics.precision[i] = precision;
    metrics.recall[i] = recall;
    metrics.f_score[i] = precision + recall > 0
                             ? 2 * precision * recall / (precision + recall)
                             : 0.0;
  }
  metrics.accuracy_median = Median(&accuracy);
  metrics.completeness_median = Median(&completeness);
  return metrics;
}

}  // namespace structnerf
