#include "colmap_plugin/evaluation/reliability.h"

#include <algorithm>
#include <cmath>

namespace structnerf {

void Reliability::Add(const double probability, const bool is_right) {
  const auto index = static_cast<size_t>(probability * kNumBins);
  Bin& bin = bins_[std::min(index, kNumBins - 1)];
  ++bin.num_pixels;
  bin.num_right += is_right;
  bin.sum_predictions += probability;
}

size_t Reliability::NumPixels() const {
  size_t num_pixels = 0;
  for (const Bin& bin : bins_) {
    num_pixels += bin.num_pixels;
  }
  return num_pixels;
}

double Reliability::MeanPrediction(const size_t bin) const {
  return bins_[bin].sum_predictions / static_cast<double>(NumPixels(bin));
}

double Reliability::ShareRight(const size_t bin) const {
  return static_cast<double>(bins_[bin].num_right) /
         static_cast<double>(NumPixels(bin));
}

double Reliability::CalibrationError() const {
  double sum = 0;
  for (const Bin& bin : bins_) {
    sum += std::abs(bin.sum_predictions - static_cast<double>(bin.num_right));
  }
  return sum / static_cast<double>(NumPixels());
}

}  // namespace structnerf
