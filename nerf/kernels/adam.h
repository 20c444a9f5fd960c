#pragma once

#include <cstddef>
#include <cstdint>

#include <hwy/base.h>

namespace structnerf {

// Adam (Kingma and Ba 2015) without bias correction of its own: the caller
// folds it into the learning rate and epsilon.
struct AdamStep {
  float learning_rate = 0;
  float beta1 = 0.9f;
  float beta2 = 0.99f;

  // Added to the root of the second moment. Small against the gradients that
  // matter, so that it only stops what is noise around zero.
  float epsilon = 1e-10f;
};

// Gradients from here on count as not finite: their squares must not overflow.
constexpr float kMaxGradient = 1e18f;

// Master copies of kGridFeatures numbers and their moments, next to each other
// since they are always used together.
struct GridEntryState {
  float value[8];
  float first_moment[8];
  float second_moment[8];
};

// Updates the grid entries of the touched blocks of 8 entries in
// [block_begin, block_end), skips entries whose gradient is zero, writes the
// half-precision copies and clears gradients and bits. Arrays start at the
// level's first entry; block_begin and block_end are multiples of 64.
// Returns false, and leaves the entry as it was, if a gradient was not finite.
bool AdamUpdateGrid(const AdamStep& step,
                    size_t block_begin,
                    size_t block_end,
                    uint64_t* touched_blocks,
                    float* gradient,
                    GridEntryState* state,
                    hwy::float16_t* table);

// Updates plain parameters.
void AdamUpdate(const AdamStep& step,
                size_t count,
                const float* gradient,
                float* first_moment,
                float* second_moment,
                float* value);

}  // namespace structnerf
