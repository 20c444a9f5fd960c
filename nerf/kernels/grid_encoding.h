#pragma once

#include "nerf/field/field_layout.h"

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

// The reverse: gradient[entry][f] += scale * weight * d_encoding. Entries
// outside [entry_begin, entry_end) are left out, so that threads can own ranges
// of the table. Bit b of `touched_blocks` is set if an entry in [b * 8, b * 8 +
// 8) got something.
void GridScatter(const float* d_encoding,
                 const uint32_t* entries,
                 const float* weights,
                 size_t num_samples,
                 size_t stride,
                 float scale,
                 size_t encoding_width,
                 uint32_t entry_begin,
                 uint32_t entry_end,
                 float* gradient,
                 uint64_t* touched_blocks);

}  // namespace structnerf
