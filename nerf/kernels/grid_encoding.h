#pragma once

#include "nerf/field/field_layout.h"
#include "nerf/kernels/grid_gradient.h"

#include <cstddef>
#include <cstdint>

#include <hwy/base.h>

namespace structnerf {

// Corners of the grid cell around each sample at one level, and their trilinear
// weights (Mueller et al. 2022, section 3). Both arrays are corner-major:
// corner c of sample s is at [c * stride + s]; `stride` is a multiple of 16 and
// at least num_samples rounded up to one. Entries are relative to the level's
// first. Positions are in field coordinates; they are clamped into the grid.
void GridCorners(const GridLevel& level,
                 const float* x,
                 const float* y,
                 const float* z,
                 size_t num_samples,
                 size_t stride,
                 uint32_t* entries,
                 float* weights);

// The same corners in pairs of neighbours along x, for the gradient. Pair p of
// sample s is at [p * stride + s]; a bucket's entries are kBucketEntries, and
// `buckets` has the bucket of the first corner in its low, that of the second
// in its high 16 bits.
void GridCornerPairs(const GridLevel& level,
                     const float* x,
                     const float* y,
                     const float* z,
                     size_t num_samples,
                     size_t stride,
                     uint32_t* buckets,
                     CornerPair* pairs);

// encoding[s * encoding_width + f] = scale * sum_c weights * table[entry][f]
// for the kGridFeatures features f of one level; `table` and `encoding` point
// at the level's first entry and first feature.
void GridInterpolate(const hwy::float16_t* table,
                     const uint32_t* entries,
                     const float* weights,
                     size_t num_samples,
                     size_t stride,
                     float scale,
                     size_t encoding_width,
                     float* encoding);

}  // namespace structnerf
