#include "colmap_plugin/evaluation/map_agreement.h"

#include "nerf/util/median.h"

namespace structnerf {
namespace {

constexpr size_t kSampleStride = 16;

MapAgreement MakeAgreement(const size_t num_common,
                           const std::array<size_t, 3>& num_within,
                           std::vector<float> differences) {
  MapAgreement agreement;
  agreement.num_common = num_common;
  if (num_common == 0) {
    return agreement;
  }
  for (size_t i = 0; i < num_within.size(); ++i) {
    agreement.shares[i] = static_cast<double>(num_within[i]) / num_common;
  }
  agreement.median_difference = Median(&differences);
  return agreement;
}

}  // namespace

MapAgreement AgreementCounter::Add(const cv::Mat1f& differences) {
  std::vector<float> common;
  std::array<size_t, 3> num_within{};
  for (const float difference : differences) {
    if (difference < 0) {
      continue;
    }
    for (size_t i = 0; i < num_within.size(); ++i) {
      num_within[i] += difference < kAgreementThresholds[i] ? 1 : 0;
    }
    if ((num_common_ + common.size()) % kSampleStride == 0) {
      sample_.push_back(difference);
    }
    common.push_back(difference);
  }
  num_common_ += common.size();
  for (size_t i = 0; i < num_within.size(); ++i) {
    num_within_[i] += num_within[i];
  }
  const size_t num_common = common.size();
  return MakeAgreement(num_common, num_within, std::move(common));
}

MapAgreement AgreementCounter::Total() const {
  return MakeAgreement(num_common_, num_within_, sample_);
}

}  // namespace structnerf
