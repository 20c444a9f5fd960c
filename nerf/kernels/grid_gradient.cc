#include "nerf/kernels/grid_gradient.h"

#include "nerf/field/field_layout.h"

#include <algorithm>
#include <cstring>

// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nerf/kernels/grid_gradient.cc"
#include <hwy/foreach_target.h>
#include <hwy/cache_control.h>
#include <hwy/highway.h>
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace structnerf {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

size_t Select(const float* HWY_RESTRICT d_encoding,
              const size_t num_samples,
              const size_t width,
              const float share,
              uint16_t* HWY_RESTRICT selected) {
  const hn::CappedTag<float, 16> d;
  const size_t lanes = hn::Lanes(d);
  auto largest = hn::Zero(d);
  for (size_t i = 0; i < num_samples * width; i += lanes) {
    largest = hn::Max(largest, hn::Abs(hn::LoadU(d, d_encoding + i)));
  }
  const auto threshold = hn::Mul(hn::MaxOfLanes(d, largest), hn::Set(d, share));
  size_t count = 0;
  for (size_t s = 0; s < num_samples; ++s) {
    // Not the other way round, so that NaN counts.
    bool is_small = true;
    for (size_t f = 0; f < width; f += lanes) {
      is_small &= hn::AllTrue(
          d,
          hn::Le(hn::Abs(hn::LoadU(d, d_encoding + s * width + f)), threshold));
    }
    selected[count] = static_cast<uint16_t>(s);
    count += !is_small;
  }
  return count;
}

void Copy(const float* HWY_RESTRICT from,
          const uint16_t* HWY_RESTRICT selected,
          const size_t num_selected,
          const size_t width,
          const float scale,
          float* HWY_RESTRICT to) {
  const hn::CappedTag<float, kGridFeatures> d;
  for (size_t i = 0; i < num_selected; ++i) {
    for (size_t f = 0; f < kGridFeatures; f += hn::Lanes(d)) {
      const auto value = hn::LoadU(d, from + selected[i] * width + f);
      hn::StoreU(
          hn::Mul(value, hn::Set(d, scale)), d, to + i * kGridFeatures + f);
    }
  }
}

void Sum(const TileCorners& corners,
         const TileCorners& next,
         float* HWY_RESTRICT gradient,
         uint8_t* HWY_RESTRICT touched) {
  const hn::CappedTag<float, kGridFeatures> d;
  const size_t lanes = hn::Lanes(d);
  constexpr uint32_t kSampleMask = (uint32_t{1} << kTileSampleBits) - 1;
  constexpr uint32_t kEntryMask = kBucketEntries - 1;
  const CornerPair* const pairs = corners.pairs;
  for (size_t i = 0; i < corners.num_pairs; ++i) {
    if (i < next.num_pairs) {
      hwy::Prefetch(next.d_encoding +
                    (next.pairs[i].index & kSampleMask) * kGridFeatures);
    }
    const uint32_t index = pairs[i].index;
    const float* const sample_gradient =
        corners.d_encoding + (index & kSampleMask) * kGridFeatures;
    const uint32_t entries[2] = {
        (index >> kTileSampleBits) & kEntryMask,
        (index >> (kTileSampleBits + kBucketBits)) & kEntryMask};
    for (int corner = 0; corner < 2; ++corner) {
      const auto weight = hn::Set(d, pairs[i].weights[corner]);
      float* const target = gradient + entries[corner] * kGridFeatures;
      for (size_t f = 0; f < kGridFeatures; f += lanes) {
        const auto sum = hn::MulAdd(
            weight, hn::LoadU(d, sample_gradient + f), hn::Load(d, target + f));
        hn::Store(sum, d, target + f);
      }
      touched[entries[corner]] = 1;
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace structnerf
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace structnerf {
namespace {

HWY_EXPORT(Select);
HWY_EXPORT(Copy);
HWY_EXPORT(Sum);

constexpr int kNumPairs = 4;
constexpr uint32_t kLowBits = 0xffff;

// Calls put(pair, bucket, corners) for all pairs of all samples. The few that
// straddle two buckets come as two whose second corner has no weight.
template <typename Put>
void ForEachPair(const uint32_t* buckets,
                 const CornerPair* pairs,
                 const size_t num_samples,
                 const size_t stride,
                 const Put& put) {
  constexpr uint32_t kEntryMask = kBucketEntries - 1;
  constexpr uint32_t kSampleMask = (uint32_t{1} << kTileSampleBits) - 1;
  for (size_t s = 0; s < num_samples; ++s) {
    for (int pair = 0; pair < kNumPairs; ++pair) {
      const uint32_t bucket = buckets[pair * stride + s] & kLowBits;
      const uint32_t other_bucket = buckets[pair * stride + s] >> 16;
      const CornerPair& corners = pairs[pair * stride + s];
      if (bucket == other_bucket) {
        put(pair, bucket, corners);
      } else {
        const uint32_t sample = corners.index & kSampleMask;
        const uint32_t entry = (corners.index >> kTileSampleBits) & kEntryMask;
        const uint32_t other_entry =
            corners.index >> (kTileSampleBits + kBucketBits);
        put(pair,
            bucket,
            {sample | entry << kTileSampleBits |
                 entry << (kTileSampleBits + kBucketBits),
             {corners.weights[0], 0.0f}});
        put(pair,
            other_bucket,
            {sample | other_entry << kTileSampleBits |
                 other_entry << (kTileSampleBits + kBucketBits),
             {corners.weights[1], 0.0f}});
      }
    }
  }
}

}  // namespace

void SortCornerPairs(const uint32_t* buckets,
                     const CornerPair* pairs,
                     const size_t num_samples,
                     const size_t stride,
                     const size_t num_buckets,
                     uint16_t* scratch,
                     uint16_t* bucket_begin,
                     CornerPair* sorted) {
  // Counting sort. Each of the four pairs counts for itself: samples in a row
  // often fall into one bucket, and increments of one counter would wait for
  // each other.
  std::fill(scratch, scratch + kNumPairs * num_buckets, uint16_t{0});
  ForEachPair(buckets,
              pairs,
              num_samples,
              stride,
              [=](const int pair, const uint32_t bucket, const CornerPair&) {
                ++scratch[bucket * kNumPairs + pair];
              });
  uint16_t begin = 0;
  for (size_t bucket = 0; bucket < num_buckets; ++bucket) {
    bucket_begin[bucket] = begin;
    for (int pair = 0; pair < kNumPairs; ++pair) {
      uint16_t& slot = scratch[bucket * kNumPairs + pair];
      const uint16_t count = slot;
      slot = begin;
      begin = static_cast<uint16_t>(begin + count);
    }
  }
  bucket_begin[num_buckets] = begin;
  ForEachPair(
      buckets,
      pairs,
      num_samples,
      stride,
      [=](const int pair, const uint32_t bucket, const CornerPair& corners) {
        sorted[scratch[bucket * kNumPairs + pair]++] = corners;
      });
}

size_t SelectSamples(const float* d_encoding,
                     const size_t num_samples,
                     const size_t width,
                     const float share,
                     uint16_t* selected) {
  return HWY_DYNAMIC_DISPATCH(Select)(
      d_encoding, num_samples, width, share, selected);
}

void CopyFeatures(const float* from,
                  const uint16_t* selected,
                  const size_t num_selected,
                  const size_t width,
                  const float scale,
                  float* to) {
  HWY_DYNAMIC_DISPATCH(Copy)(from, selected, num_selected, width, scale, to);
}

void SumCorners(const TileCorners& corners,
                const TileCorners& next,
                float* gradient,
                uint8_t* touched) {
  HWY_DYNAMIC_DISPATCH(Sum)(corners, next, gradient, touched);
}

size_t ListTouched(uint8_t* touched, uint16_t* entries) {
  size_t count = 0;
  for (uint32_t begin = 0; begin < kBucketEntries; begin += 8) {
    uint64_t flags;
    std::memcpy(&flags, touched + begin, sizeof(flags));
    if (flags == 0) {
      continue;
    }
    for (uint32_t i = 0; i < 8; ++i) {
      entries[count] = static_cast<uint16_t>(begin + i);
      count += touched[begin + i];
    }
    std::memset(touched + begin, 0, sizeof(flags));
  }
  return count;
}

}  // namespace structnerf
#endif  // HWY_ONCE
