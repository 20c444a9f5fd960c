#pragma once

#include <array>
#include <cstddef>
#include <vector>

namespace structnerf {

// Absolute errors that shares of pixels and points are counted for, in metres.
constexpr std::array<double, 3> kErrorThresholds = {0.02, 0.05, 0.10};
constexpr std::array<const char*, 3> kErrorThresholdNames = {
    "2cm", "5cm", "10cm"};

// Truth is rounded to millimetres, so an error of exactly the threshold must
// not depend on rounding.
constexpr double kThresholdSlack = 1e-6;

// Errors in metres over pixels that have truth. RMSE, median, relative error
// and delta are over those with a prediction; completeness and the shares
// within a threshold are of all, so that a missing pixel is a failure.
struct DepthMetrics {
  size_t num_pixels = 0;       // with truth
  size_t num_predictions = 0;  // of these, with a prediction
  double completeness = 0;     // share, in [0, 1]
  double rmse = 0;
  double median_error = 0;
  double abs_rel = 0;              // mean of |error| / truth
  std::array<double, 3> delta{};   // max(p / t, t / p) < 1.25, 1.25^2, 1.25^3
  std::array<double, 3> within{};  // |error| below kErrorThresholds
};

class DepthErrors {
 public:
  // Metres; `truth` is positive, `prediction` 0 if missing.
  void Add(float truth, float prediction);

  DepthMetrics Compute() const;

 private:
  size_t num_pixels_ = 0;
  std::vector<float> errors_;
  double sum_squares_ = 0;
  double sum_relative_ = 0;
  std::array<size_t, 3> num_delta_{};
  std::array<size_t, 3> num_within_{};
};

}  // namespace structnerf
