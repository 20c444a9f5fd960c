#include "colmap_plugin/evaluation/depth_metrics.h"

#include "nerf/util/median.h"

#include <algorithm>
#include <cmath>

namespace structnerf {
namespace {

constexpr std::array<double, 3> kDeltas = {
    1.25, 1.25 * 1.25, 1.25 * 1.25 * 1.25};

double Share(const size_t part, const size_t whole) {
  return whole > 0 ? static_cast<double>(part) / whole : 0.0;
}

}  // namespace

void DepthErrors::Add(const float truth, const float prediction) {
  ++num_pixels_;
  if (!(prediction > 0)) {
    return;
  }
  const double t = truth;
  const double p = prediction;
  const double error = std::abs(p - t);
  errors_.push_back(static_cast<float>(error));
  sum_squares_ += error * error;
  sum_relative_ += error / t;
  const double ratio = std::max(p / t, t / p);
  for (size_t i = 0; i < kDeltas.size(); ++i) {
    num_delta_[i] += ratio < kDeltas[i];
  }
  for (size_t i = 0; i < kErrorThresholds.size(); ++i) {
    num_within_[i] += error < kErrorThresholds[i] + kThresholdSlack;
  }
}

DepthMetrics DepthErrors::Compute() const {
  DepthMetrics metrics;
  metrics.num_pixels = num_pixels_;
  metrics.num_predictions = errors_.size();
  metrics.completeness = Share(errors_.size(), num_pixels_);
  for (size_t i = 0; i < kErrorThresholds.size(); ++i) {
    metrics.within[i] = Share(num_within_[i], num_pixels_);
  }
  if (errors_.empty()) {
    return metrics;
  }
  const double num_errors = static_cast<double>(errors_.size());
  metrics.rmse = std::sqrt(sum_squares_ / num_errors);
  metrics.abs_rel = sum_relative_ / num_errors;
  for (size_t i = 0; i < kDeltas.size(); ++i) {
    metrics.delta[i] = Share(num_delta_[i], errors_.size());
  }
  std::vector<float> errors = errors_;
  metrics.median_error = Median(&errors);
  return metrics;
}

}  // namespace structnerf
