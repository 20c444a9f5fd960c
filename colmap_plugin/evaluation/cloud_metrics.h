#pragma once

#include "colmap_plugin/evaluation/depth_metrics.h"

#include <array>
#include <cstddef>
#include <vector>

#include <Eigen/Core>

namespace structnerf {

// Two clouds against each other, distances in the unit of the points (metres).
// Distances of more than one metre count as one.
struct CloudMetrics {
  size_t num_predicted_points = 0;
  size_t num_true_points = 0;

  // Distance from a predicted point to the truth, and the other way round.
  double accuracy_mean = 0;
  double accuracy_median = 0;
  double completeness_mean = 0;
  double completeness_median = 0;

  // At kErrorThresholds: share of the predicted points near the truth, of the
  // true points near the prediction, and the harmonic mean of the two.
  std::array<double, 3> precision{};
  std::array<double, 3> recall{};
  std::array<double, 3> f_score{};
};

// All zero if a cloud is empty.
CloudMetrics CompareClouds(const std::vector<Eigen::Vector3d>& predicted,
                           const std::vector<Eigen::Vector3d>& truth);

}  // namespace structnerf
