#pragma once

#include "nerf/engine/ray_tile.h"
#include "nerf/field/density_cache.h"

#include <cstddef>

namespace structnerf {

// Most bins along a ray.
constexpr int kMaxRayBins = 256;

struct RaySamplingParameters {
  int num_bins = 96;
  int num_samples = 16;

  // Share of the samples that is spread evenly over the bins, whatever the
  // density, so that a surface the cache does not know of is found.
  float uniform_share = 0.5f;
};

// Chooses the intervals of one tile's rays. Each ray is cut into bins of equal
// ratio of z-depth between near and far; the density cache gives the share of
// the light that ends in each; num_samples + 1 edges then cut the ray into
// intervals of about equal share. The first edge is near, the last is far.
//
//   jitter: a number in [0, 1) per ray that shifts the inner edges.
//   edges: rays x (num_samples + 1), ascending.
void ChooseIntervals(const RayTile& rays,
                     const DensityCache& cache,
                     const RaySamplingParameters& parameters,
                     const PerRay<float>& jitter,
                     float* edges);

}  // namespace structnerf
