// Kernels that only training has, on every instruction set of this machine:
// gradients of layers and of the grid, as large and as small as they get.

#include "nerf/field/field_layout.h"
#include "nerf/kernels/dense_layer.h"
#include "nerf/kernels/grid_encoding.h"
#include "nerf/kernels/grid_gradient.h"
#include "nerf/train/training_guards.h"
#include "tests/stability/simd_extremes.h"
#include "tests/stability/stability_case.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string>
#include <vector>

namespace structnerf {
namespace {

constexpr float kMaxWeight = TrainingGuards::kMaxParameter;

// Beyond, Adam refuses a step.
constexpr float kMaxGradient = 9.9e17f;

const std::vector<float> kGradients = {
    -kMaxGradient, -1, -1e-40f, 0, 1e-20f, 1, kMaxGradient};
const std::vector<float> kValues = {-kMaxWeight, 1e-40f, 0, 1, kMaxWeight};

// A sum in double and the sum of the sizes of what it is made of.
struct DoubleSum {
  double value = 0;
  double magnitude = 0;

  void Add(const double term) {
    value += term;
    magnitude += std::abs(term);
  }

  // Of a sum in float, relative to its terms.
  double ErrorOf(const float sum) const {
    return std::abs(sum - value) / std::max(magnitude, 1e-30);
  }
};

std::string MeasureLayerGradients() {
  constexpr size_t kRows = 9;
  constexpr size_t kWidth = 32;
  const double worst = WorstOfTargets([] {
    const auto x = PickMany(kValues, kRows * kWidth, 1);
    const auto w_transposed = PickMany(kValues, kWidth * kWidth, 2);
    const auto dy = PickMany(kGradients, kRows * kWidth, 3);
    double error = 0;

    std::vector<float> dx(kRows * kWidth);
    DenseBackwardInput(dy.data(),
                       kWidth,
                       w_transposed.data(),
                       x.data(),
                       kRows,
                       kWidth,
                       kWidth,
                       dx.data());
    RequireFinite(dx, "a gradient by an input");
    for (size_t row = 0; row < kRows; ++row) {
      for (size_t k = 0; k < kWidth; ++k) {
        DoubleSum sum;
        for (size_t col = 0; col < kWidth && x[row * kWidth + k] > 0; ++col) {
          sum.Add(static_cast<double>(dy[row * kWidth + col]) *
                  w_transposed[col * kWidth + k]);
        }
        error = std::max(error, sum.ErrorOf(dx[row * kWidth + k]));
      }
    }

    std::vector<float> dw(kWidth * kWidth, 1.0f);
    DenseBackwardWeights(
        x.data(), kWidth, dy.data(), kRows, kWidth, kWidth, dw.data());
    RequireFinite(dw, "a gradient by a weight");
    for (size_t k = 0; k < kWidth; ++k) {
      for (size_t col = 0; col < kWidth; ++col) {
        DoubleSum sum;
        sum.Add(1);
        for (size_t row = 0; row < kRows; ++row) {
          sum.Add(static_cast<double>(x[row * kWidth + k]) *
                  dy[row * kWidth + col]);
        }
        error = std::max(error, sum.ErrorOf(dw[k * kWidth + col]));
      }
    }

    const std::vector<uint32_t> groups = {0, 1, 1, 0, 1, 1, 0, 1, 0};
    std::vector<float> sums(2 * kWidth, 1.0f);
    DenseSumRows(dy.data(), groups.data(), kRows, kWidth, sums.data());
    RequireFinite(sums, "a gradient by a bias");
    for (size_t i = 0; i < sums.size(); ++i) {
      DoubleSum sum;
      sum.Add(1);
      for (size_t row = 0; row < kRows; ++row) {
        if (groups[row] == i / kWidth) {
          sum.Add(dy[row * kWidth + i % kWidth]);
        }
      }
      error = std::max(error, sum.ErrorOf(sums[i]));
    }
    return error;
  });
  RequireStable(worst < 1e-5, "gradients are off by " + ShortNumber(worst));
  return "by inputs, weights and biases within " + ShortNumber(worst) +
         " of double, relative to their terms";
}

// The guards can only act on what they see.
std::string MeasureLostGradients() {
  WorstOfTargets([] {
    constexpr size_t kRows = 3;
    constexpr size_t kWidth = 16;
    const std::vector<float> ones(kWidth * kWidth, 1.0f);
    for (const float bad : {kInfinity, -kInfinity, kNan}) {
      std::vector<float> dy(kRows * kWidth, 0.0f);
      dy[kWidth + 5] = bad;
      std::vector<float> dx(kRows * kWidth);
      DenseBackwardInput(dy.data(),
                         kWidth,
                         ones.data(),
                         ones.data(),
                         kRows,
                         kWidth,
                         kWidth,
                         dx.data());
      std::vector<float> dw(kWidth * kWidth);
      DenseBackwardWeights(
          ones.data(), kWidth, dy.data(), kRows, kWidth, kWidth, dw.data());
      std::vector<float> sums(kWidth);
      DenseSumRows(dy.data(), nullptr, kRows, kWidth, sums.data());
      RequireStable(!std::isfinite(dx[kWidth]) && !std::isfinite(dw[5]) &&
                        !std::isfinite(sums[5]),
                    ShortNumber(bad) + " is lost");
      RequireStable(dx[0] == 0 && dw[4] == 0 && sums[4] == 0,
                    ShortNumber(bad) + " spreads");
      // An infinite one leaves no sample that matters beside it.
      std::vector<uint16_t> selected(kRows + 1);
      const size_t num_selected =
          SelectSamples(dy.data(), kRows, kWidth, 1e-3f, selected.data());
      RequireStable(std::isinf(bad) || (num_selected == 1 && selected[0] == 1),
                    "a sample with no number is left out");
    }
    return 0.0;
  });
  return "reach the sums that they belong to and no other";
}

// All that becomes of the gradient of one tile at one level, entry by entry.
double GridGradientError(const GridLevel& level,
                         const std::vector<float>& x,
                         const std::vector<float>& y,
                         const std::vector<float>& z,
                         const size_t num_samples,
                         const std::vector<float>& d_encoding) {
  const size_t stride = x.size();
  std::vector<uint32_t> entries(8 * stride);
  std::vector<float> weights(8 * stride);
  GridCorners(level,
              x.data(),
              y.data(),
              z.data(),
              num_samples,
              stride,
              entries.data(),
              weights.data());
  std::vector<DoubleSum> expected(level.num_entries * kGridFeatures);
  for (size_t s = 0; s < num_samples; ++s) {
    for (size_t corner = 0; corner < 8; ++corner) {
      for (size_t f = 0; f < kGridFeatures; ++f) {
        expected[entries[corner * stride + s] * kGridFeatures + f].Add(
            static_cast<double>(weights[corner * stride + s]) *
            d_encoding[s * kGridFeatures + f]);
      }
    }
  }

  std::vector<uint32_t> buckets(4 * stride);
  std::vector<CornerPair> pairs(4 * stride);
  GridCornerPairs(level,
                  x.data(),
                  y.data(),
                  z.data(),
                  num_samples,
                  stride,
                  buckets.data(),
                  pairs.data());
  const size_t num_buckets =
      (level.num_entries + kBucketEntries - 1) / kBucketEntries;
  for (const uint32_t bucket : buckets) {
    RequireStable((bucket & 0xffff) < num_buckets && bucket >> 16 < num_buckets,
                  "a bucket does not exist");
  }
  std::vector<uint16_t> scratch(4 * num_buckets);
  std::vector<uint16_t> bucket_begin(num_buckets + 1);
  std::vector<CornerPair> sorted(8 * num_samples);
  SortCornerPairs(buckets.data(),
                  pairs.data(),
                  num_samples,
                  stride,
                  num_buckets,
                  scratch.data(),
                  bucket_begin.data(),
                  sorted.data());
  double error = 0;
  for (size_t bucket = 0; bucket < num_buckets; ++bucket) {
    alignas(64) static float gradient[kBucketEntries * kGridFeatures];
    std::fill(std::begin(gradient), std::end(gradient), 0.0f);
    std::vector<uint8_t> touched(kBucketEntries);
    TileCorners corners;
    corners.pairs = sorted.data() + bucket_begin[bucket];
    corners.num_pairs = bucket_begin[bucket + 1] - bucket_begin[bucket];
    corners.d_encoding = d_encoding.data();
    SumCorners(corners, TileCorners(), gradient, touched.data());
    const size_t first = bucket * kBucketEntries * kGridFeatures;
    for (size_t i = 0; i < std::size(gradient) && first + i < expected.size();
         ++i) {
      RequireStable(std::isfinite(gradient[i]),
                    "a gradient is " + ShortNumber(gradient[i]));
      error = std::max(error, expected[first + i].ErrorOf(gradient[i]));
    }
  }
  return error;
}

std::string MeasureGridGradient() {
  const double worst = WorstOfTargets([] {
    const FieldLayout layout = ExtremeLayout();
    constexpr size_t kSamples = 64;
    const auto x = ExtremePlaces(kSamples, 1);
    const auto y = ExtremePlaces(kSamples, 2);
    const auto z = ExtremePlaces(kSamples, 3);

    // The features of two levels, of which the second is looked at; samples of
    // zeros are left out.
    constexpr size_t kWidth = 2 * kGridFeatures;
    auto all = PickMany(kGradients, kSamples * kWidth, 4);
    std::fill_n(all.begin(), kWidth, 0.0f);
    std::vector<uint16_t> selected(kSamples + 1);
    selected.resize(
        SelectSamples(all.data(), kSamples, kWidth, 0, selected.data()));
    RequireStable(selected.size() == kSamples - 1 && selected[0] == 1,
                  std::to_string(selected.size()) + " samples were selected");
    std::vector<float> d_encoding(selected.size() * kGridFeatures);
    constexpr float kScale = 0.5f;
    CopyFeatures(all.data() + kGridFeatures,
                 selected.data(),
                 selected.size(),
                 kWidth,
                 kScale,
                 d_encoding.data());
    double error = 0;
    for (size_t i = 0; i < d_encoding.size(); ++i) {
      const size_t s = selected[i / kGridFeatures];
      DoubleSum copied;
      copied.Add(kScale * all[s * kWidth + kGridFeatures + i % kGridFeatures]);
      error = std::max(error, copied.ErrorOf(d_encoding[i]));
    }
    for (const GridLevel& level : layout.levels) {
      error = std::max(
          error,
          GridGradientError(level, x, y, z, selected.size(), d_encoding));
    }
    return error;
  });
  RequireStable(worst < 1e-5, "gradients are off by " + ShortNumber(worst));
  return "buckets exist, sums within " + ShortNumber(worst) +
         " of double, relative to their terms, also for places at infinity and "
         "none";
}

}  // namespace

std::vector<StabilityCase> GradientKernelCases() {
  return {{"gradients of layers: 1e-40 to 1e18", MeasureLayerGradients},
          {"gradients of layers: infinite or no number", MeasureLostGradients},
          {"gradients of the grid: 1e-40 to 1e18", MeasureGridGradient}};
}

}  // namespace structnerf
