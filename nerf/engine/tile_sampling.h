#pragma once

#include "nerf/engine/ray_tile.h"
#include "nerf/field/density_cache.h"
#include "nerf/kernels/ray_sampling.h"
#include "nerf/util/random.h"

namespace structnerf {

// Chooses the intervals of a tile's rays and one point in each at which the
// field is evaluated. All engines sample with this function, so that they can
// be compared.
//
// Half of the inner edges of a guided ray are drawn from the normal
// distribution that guides it (Roessle et al. 2022, "Dense Depth Priors",
// section 3.3), in training only.
//
//   random: with it, edges and points are jittered (training); null puts the
//     points in the middle of evenly placed intervals (rendering).
//   edges: rays x (num_samples + 1), z-depth.
//   x, y, z: rays x num_samples, field coordinates.
void SampleTile(const RayTile& rays,
                const DensityCache& cache,
                const RaySamplingParameters& parameters,
                Random* random,
                float* edges,
                float* x,
                float* y,
                float* z);

// The first spherical harmonics of a ray's direction, at most
// kMaxNumHarmonics, in the order of their degree and padded with zeros to
// kDirectionWidth. (Real basis, orthonormal on the sphere.)
void EncodeDirection(const RayTile& rays,
                     int ray,
                     int num_harmonics,
                     float* encoding);

}  // namespace structnerf
