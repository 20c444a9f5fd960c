#pragma once

#include "nerf/options.h"
#include "nerf/util/random.h"

#include <cstddef>
#include <vector>

namespace structnerf {

// One ray's points, and the intervals they stand for in the quadrature.
struct RayPoints {
  std::vector<float> edges;  // n + 1, z-depth, from near to far
  std::vector<float> depth;  // n, z-depth, ascending, one in each interval
};

// `count` intervals of equal length and a point in each: anywhere with
// `random` (training), in the middle with null (rendering). (Mildenhall et al.
// 2020, eq. 2.)
RayPoints StratifiedPoints(float near, float far, int count, Random* random);

// The points of `coarse` and `count` more, drawn from the share of light
// `weight` that ends in each of its intervals (Mildenhall et al. 2020, section
// 5.2). Intervals end halfway between points. With `random` the draws are
// jittered, else at the middles of equal shares.
//   guide_depth, guide_deviation: of a guided ray (RayTile), half of whose
//   draws
//     are from that normal distribution instead; depth 0 = none. Only with
//     `random`.
RayPoints RefinedPoints(const RayPoints& coarse,
                        const float* weight,
                        int count,
                        float guide_depth,
                        float guide_deviation,
                        Random* random);

// How many tiles of rays, at least one, are evaluated at a time, and how many
// points of both networks these have: their activations are kept for the
// gradient, some 12 KB each in NeRF's network.
struct MlpBatchSize {
  explicit MlpBatchSize(const SamplingOptions& sampling);

  size_t num_tiles = 0;
  size_t num_points = 0;
};

}  // namespace structnerf
