#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include <opencv2/core.hpp>

namespace structnerf {

// Relative differences of depth up to which two maps agree.
constexpr std::array<double, 3> kAgreementThresholds = {0.01, 0.02, 0.05};

// How two maps of one view, or of many, agree.
struct MapAgreement {
  size_t num_common = 0;  // pixels where both have depth
  double median_difference = 0;
  std::array<double, 3> shares{};  // below kAgreementThresholds
};

class AgreementCounter {
 public:
  // Relative differences of one view, negative = none; returns what they say.
  MapAgreement Add(const cv::Mat1f& differences);

  // Over all views so far. The median is that of every 16th pixel, since those
  // of all views need not fit into memory.
  MapAgreement Total() const;

 private:
  size_t num_common_ = 0;
  std::array<size_t, 3> num_within_{};
  std::vector<float> sample_;
};

}  // namespace structnerf
