#pragma once

#include <array>
#include <cstddef>

namespace structnerf {

// What a predicted probability is worth: predictions are sorted into bins of
// equal width, and in each the mean prediction is compared with the share of
// the pixels that were right.
class Reliability {
 public:
  static constexpr size_t kNumBins = 10;

  // `probability` in [0, 1].
  void Add(double probability, bool is_right);

  size_t NumPixels() const;

  // Of one bin; NumPixels is 0 where there is nothing to tell.
  size_t NumPixels(size_t bin) const { return bins_[bin].num_pixels; }
  double MeanPrediction(size_t bin) const;
  double ShareRight(size_t bin) const;

  // Mean over all pixels of the distance between the two ("expected
  // calibration error", Guo et al. 2017).
  double CalibrationError() const;

 private:
  struct Bin {
    size_t num_pixels = 0;
    size_t num_right = 0;
    double sum_predictions = 0;
  };
  std::array<Bin, kNumBins> bins_;
};

}  // namespace structnerf
