#pragma once

#include <cstddef>
#include <cstdint>

#include <hwy/base.h>

namespace structnerf {

// Adam (Kingma and Ba 2015) without bias correction of its own: the caller
// folds it into the learning rate. With gradient g,
//   m = beta1 m + (1 - beta1) g,  v = beta2 v + (1 - beta2) g^2,
//   value -= learning_rate m / sqrt(v + epsilon^2).
// What is stored is m and the root of v.
struct AdamStep {
  float learning_rate = 0;
  float beta1 = 0.9f;
  float beta2 = 0.99f;

  // Small against the gradients that matter, so that it only stops what is
  // noise around zero.
  float epsilon = 1e-10f;
};

// Gradients from here on count as not finite: their squares must not overflow.
constexpr float kMaxGradient = 1e18f;

// Master copies of the features of a grid entry and their moments, in one cache
// line: the optimiser's time goes into moving these. Moments are rounded to 16
// bits of a float, m without the lower 16, the root of v without the sign and
// the lower 15. It then differs from its exact value by less than a fall
// through (1 - beta2) / 2 in one step, so it cannot get stuck; step sizes come
// out right within a few percent.
struct alignas(64) GridEntryState {
  float value[8];
  uint16_t first_moment[8];
  uint16_t root_second_moment[8];
};
static_assert(sizeof(GridEntryState) == 64);

// Updates the listed grid entries, skipping those whose gradient is zero,
// writes the half-precision copies and clears the gradients. Arrays have
// kGridFeatures numbers per entry and start at the same one. Returns false, and
// leaves the entry as it was, if a gradient was not finite.
bool AdamUpdateGrid(const AdamStep& step,
                    const uint16_t* entries,
                    size_t num_entries,
                    float* gradient,
                    GridEntryState* state,
                    hwy::float16_t* table);

// Updates plain parameters.
void AdamUpdate(const AdamStep& step,
                size_t count,
                const float* gradient,
                float* first_moment,
                float* root_second_moment,
                float* value);

}  // namespace structnerf
