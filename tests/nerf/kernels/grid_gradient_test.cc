#include "nerf/kernels/grid_gradient.h"

#include "nerf/engine/ray_tile.h"
#include "nerf/field/field_layout.h"
#include "tests/nerf/random_values.h"
#include "tests/nerf/simd_targets.h"

#include <cmath>
#include <limits>
#include <map>
#include <utility>
#include <vector>

namespace structnerf {
namespace {

static_assert(kMaxTileRays * kMaxRaySamples <= 1 << kTileSampleBits,
              "a sample's number must fit");

constexpr size_t kNumBuckets = 5;
constexpr uint32_t kEntryMask = kBucketEntries - 1;
constexpr uint32_t kSampleMask = (1u << kTileSampleBits) - 1;

class GridGradientTest : public SimdTargetTest {};

uint32_t FirstEntry(const CornerPair& pair) {
  return (pair.index >> kTileSampleBits) & kEntryMask;
}

uint32_t SecondEntry(const CornerPair& pair) {
  return pair.index >> (kTileSampleBits + kBucketBits);
}

// Corners of the samples of a tile, four pairs each.
struct Corners {
  explicit Corners(const size_t num_samples, const double straddling_share)
      : stride((num_samples + 15) / 16 * 16),
        buckets(4 * stride),
        pairs(4 * stride) {
    Random random(num_samples);
    for (size_t pair = 0; pair < 4; ++pair) {
      for (size_t s = 0; s < num_samples; ++s) {
        const uint32_t first = random.NextBelow(kNumBuckets * kBucketEntries);
        uint32_t second = random.NextBelow(kBucketEntries) +
                          first / kBucketEntries * kBucketEntries;
        if (random.NextFloat() < straddling_share) {
          second = random.NextBelow(kNumBuckets * kBucketEntries);
        }
        const size_t index = pair * stride + s;
        buckets[index] = first / kBucketEntries | second / kBucketEntries << 16;
        pairs[index].index =
            static_cast<uint32_t>(s) | (first & kEntryMask) << kTileSampleBits |
            (second & kEntryMask) << (kTileSampleBits + kBucketBits);
        pairs[index].weights[0] = random.NextFloat();
        pairs[index].weights[1] = random.NextFloat();
        // What each sample gives to each entry.
        weights[{first, static_cast<uint32_t>(s)}] += pairs[index].weights[0];
        weights[{second, static_cast<uint32_t>(s)}] += pairs[index].weights[1];
      }
    }
  }

  size_t stride;
  std::vector<uint32_t> buckets;
  std::vector<CornerPair> pairs;
  std::map<std::pair<uint32_t, uint32_t>, double> weights;
};

TEST_P(GridGradientTest, SortKeepsEveryCorner) {
  for (const size_t num_samples : {0, 1, 3, 100, 2048}) {
    for (const double straddling_share : {0.0, 0.1, 1.0}) {
      const Corners corners(num_samples, straddling_share);
      std::vector<uint16_t> scratch(4 * kNumBuckets);
      std::vector<uint16_t> bucket_begin(kNumBuckets + 1);
      std::vector<CornerPair> sorted(8 * num_samples);
      SortCornerPairs(corners.buckets.data(),
                      corners.pairs.data(),
                      num_samples,
                      corners.stride,
                      kNumBuckets,
                      scratch.data(),
                      bucket_begin.data(),
                      sorted.data());
      EXPECT_EQ(bucket_begin[0], 0);
      std::map<std::pair<uint32_t, uint32_t>, double> weights;
      for (uint32_t bucket = 0; bucket < kNumBuckets; ++bucket) {
        for (size_t i = bucket_begin[bucket]; i < bucket_begin[bucket + 1];
             ++i) {
          const uint32_t sample = sorted[i].index & kSampleMask;
          const uint32_t first = bucket * kBucketEntries;
          weights[{first + FirstEntry(sorted[i]), sample}] +=
              sorted[i].weights[0];
          weights[{first + SecondEntry(sorted[i]), sample}] +=
              sorted[i].weights[1];
        }
      }
      ASSERT_EQ(weights.size(), corners.weights.size());
      for (const auto& [key, weight] : corners.weights) {
        ASSERT_NEAR(weights[key], weight, 1e-6);
      }
    }
  }
}

TEST_P(GridGradientTest, SumCorners) {
  constexpr size_t kNumSamples = 60;
  const auto d_encoding = RandomValues(kNumSamples * kGridFeatures, -1, 1, 1);
  for (const size_t num_pairs : {0, 1, 2, 333}) {
    Random random(num_pairs);
    std::vector<CornerPair> pairs(num_pairs);
    std::vector<double> expected(kBucketEntries * kGridFeatures);
    std::vector<uint8_t> expected_touched(kBucketEntries);
    for (CornerPair& pair : pairs) {
      const uint32_t sample = random.NextBelow(kNumSamples);
      // Few entries, so that some are hit often, also both at once.
      const uint32_t entries[2] = {random.NextBelow(20) * 53,
                                   random.NextBelow(20) * 53};
      pair.index = sample | entries[0] << kTileSampleBits |
                   entries[1] << (kTileSampleBits + kBucketBits);
      for (int corner = 0; corner < 2; ++corner) {
        pair.weights[corner] = random.NextFloat();
        expected_touched[entries[corner]] = 1;
        for (int f = 0; f < kGridFeatures; ++f) {
          expected[entries[corner] * kGridFeatures + f] +=
              static_cast<double>(pair.weights[corner]) *
              d_encoding[sample * kGridFeatures + f];
        }
      }
    }
    alignas(64) static float gradient[kBucketEntries * kGridFeatures];
    std::fill(std::begin(gradient), std::end(gradient), 0.0f);
    std::vector<uint8_t> touched(kBucketEntries);
    TileCorners corners;
    corners.pairs = pairs.data();
    corners.num_pairs = num_pairs;
    corners.d_encoding = d_encoding.data();
    // In two parts, of which the first knows the second.
    TileCorners first = corners;
    first.num_pairs = num_pairs / 3;
    TileCorners second = corners;
    second.pairs += first.num_pairs;
    second.num_pairs -= first.num_pairs;
    SumCorners(first, second, gradient, touched.data());
    SumCorners(second, TileCorners(), gradient, touched.data());
    EXPECT_EQ(touched, expected_touched);
    for (size_t i = 0; i < expected.size(); ++i) {
      ASSERT_NEAR(gradient[i], expected[i], 1e-5);
    }
  }
}

TEST_P(GridGradientTest, ListTouchedEmptiesTheList) {
  std::vector<uint8_t> touched(kBucketEntries);
  std::vector<uint16_t> entries(kBucketEntries);
  EXPECT_EQ(ListTouched(touched.data(), entries.data()), 0u);
  const std::vector<uint16_t> expected = {
      0, 1, 7, 8, 500, kBucketEntries - 8, kBucketEntries - 1};
  for (const uint16_t entry : expected) {
    touched[entry] = 1;
  }
  ASSERT_EQ(ListTouched(touched.data(), entries.data()), expected.size());
  for (size_t i = 0; i < expected.size(); ++i) {
    EXPECT_EQ(entries[i], expected[i]);
  }
  EXPECT_EQ(ListTouched(touched.data(), entries.data()), 0u);

  touched.assign(kBucketEntries, 1);
  EXPECT_EQ(ListTouched(touched.data(), entries.data()), kBucketEntries);
  EXPECT_EQ(entries[kBucketEntries - 1], kBucketEntries - 1);
}

TEST_P(GridGradientTest, SelectSamplesThatMatter) {
  for (const size_t width : {16, 32, 64}) {
    constexpr size_t kNumSamples = 9;
    std::vector<float> d_encoding(kNumSamples * width);
    const auto at = [&](const size_t s, const size_t f) -> float& {
      return d_encoding[s * width + f];
    };
    at(1, 0) = -2.0f;            // the largest
    at(2, width - 1) = 2.1e-3f;  // just enough
    at(3, 5) = 1.9e-3f;          // not enough
    at(5, 7) = -2.1e-3f;
    at(8, 3) = 1.0f;
    std::vector<uint16_t> selected(kNumSamples + 1);
    const size_t count = SelectSamples(
        d_encoding.data(), kNumSamples, width, 1e-3f, selected.data());
    selected.resize(count);
    EXPECT_EQ(selected, (std::vector<uint16_t>{1, 2, 5, 8}));
  }
}

TEST_P(GridGradientTest, SelectNothingOfNothing) {
  std::vector<float> d_encoding(3 * 16);
  std::vector<uint16_t> selected(4);
  EXPECT_EQ(SelectSamples(d_encoding.data(), 0, 16, 1e-3f, selected.data()),
            0u);
  EXPECT_EQ(SelectSamples(d_encoding.data(), 3, 16, 1e-3f, selected.data()),
            0u);
}

// A gradient that is not a number must reach the update, which refuses it.
TEST_P(GridGradientTest, SelectsNotANumber) {
  std::vector<float> d_encoding(3 * 16, 1.0f);
  d_encoding[16 + 2] = std::numeric_limits<float>::quiet_NaN();
  std::vector<uint16_t> selected(4);
  const size_t count =
      SelectSamples(d_encoding.data(), 3, 16, 1e-3f, selected.data());
  EXPECT_NE(std::find(selected.begin(), selected.begin() + count, 1),
            selected.begin() + count);
}

TEST_P(GridGradientTest, CopyFeatures) {
  constexpr size_t kWidth = 32;
  const auto from = RandomValues(10 * kWidth, -1, 1, 1);
  const std::vector<uint16_t> selected = {0, 3, 4, 9};
  std::vector<float> to(selected.size() * kGridFeatures);
  CopyFeatures(from.data() + 8,
               selected.data(),
               selected.size(),
               kWidth,
               0.5f,
               to.data());
  for (size_t i = 0; i < selected.size(); ++i) {
    for (int f = 0; f < kGridFeatures; ++f) {
      EXPECT_EQ(to[i * kGridFeatures + f],
                0.5f * from[selected[i] * kWidth + 8 + f]);
    }
  }
}

STRUCTNERF_FOR_EACH_SIMD_TARGET(GridGradientTest);

}  // namespace
}  // namespace structnerf
