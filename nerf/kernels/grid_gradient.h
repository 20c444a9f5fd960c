#pragma once

#include <cstddef>
#include <cstdint>

namespace structnerf {

// The gradient of a grid level is a sum over samples and cell corners that hits
// entries in random order. It is formed in two passes that both stay in the
// first-level caches: each tile sorts its corners by bucket, a range of
// kBucketEntries entries; then each bucket sums up what all tiles have for it.
// Whoever does it, an entry's sum runs in the order of the tiles.

constexpr int kBucketBits = 10;
constexpr uint32_t kBucketEntries = uint32_t{1} << kBucketBits;

// Most samples of a tile, kMaxTileRays * kMaxRaySamples.
constexpr int kTileSampleBits = 11;

// A sample's weights at two corners that are neighbours along x.
struct CornerPair {
  // sample | (entry of the first corner << kTileSampleBits) | (entry of the
  // second << (kTileSampleBits + kBucketBits)); entries relative to the bucket.
  uint32_t index;
  float weights[2];
};

// Share of a tile's largest gradient below which one is rounding. Adam would
// turn it into a step of full size.
constexpr float kNegligibleGradient = 1e-7f;

// Lists the samples whose gradient matters: those with a number larger than
// `share` of the largest of all. Returns their count.
//   d_encoding: samples x width, width a multiple of 16.
size_t SelectSamples(const float* d_encoding,
                     size_t num_samples,
                     size_t width,
                     float share,
                     uint16_t* selected);

// to[i][f] = scale * from[selected[i] * width + f] for the kGridFeatures
// features f.
void CopyFeatures(const float* from,
                  const uint16_t* selected,
                  size_t num_selected,
                  size_t width,
                  float scale,
                  float* to);

// Sorts the corner pairs of one tile's samples at one level (GridCornerPairs)
// by bucket. A pair that straddles two buckets becomes two with one corner
// each.
//   scratch: 4 * num_buckets.
//   bucket_begin: num_buckets + 1.
//   sorted: room for 8 * num_samples. Those of bucket b are
//     [bucket_begin[b], bucket_begin[b + 1]).
void SortCornerPairs(const uint32_t* buckets,
                     const CornerPair* pairs,
                     size_t num_samples,
                     size_t stride,
                     size_t num_buckets,
                     uint16_t* scratch,
                     uint16_t* bucket_begin,
                     CornerPair* sorted);

// What one tile has for one bucket.
struct TileCorners {
  const CornerPair* pairs = nullptr;
  size_t num_pairs = 0;
  const float* d_encoding = nullptr;  // samples x kGridFeatures
};

// gradient[entry][f] += weight * d_encoding[sample][f] for the kGridFeatures
// features f, and touched[entry] = 1. What will be read for `next` is requested
// from memory.
//   gradient: kBucketEntries x kGridFeatures. touched: kBucketEntries.
void SumCorners(const TileCorners& corners,
                const TileCorners& next,
                float* gradient,
                uint8_t* touched);

// Lists the touched entries in ascending order, returns their number and clears
// `touched`.
size_t ListTouched(uint8_t* touched, uint16_t* entries);

}  // namespace structnerf
