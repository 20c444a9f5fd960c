#pragma once

#include <cstddef>
#include <cstdint>

namespace structnerf {

// Colour of a tile's rays from the samples that have one,
//   color_r = sum_i w_i c_i / sum_i w_i,
// i over the ray's active samples. Rows of colours have kColorOutputWidth
// numbers of which the first three count; rows of rays have kRayColorWidth.
constexpr size_t kRayColorWidth = 4;

struct ActiveColors {
  size_t count = 0;
  const uint32_t* samples = nullptr;  // active samples, in the order of rays
  const uint32_t* rays = nullptr;     // the ray each belongs to
  const float* color = nullptr;       // count x kColorOutputWidth
  const float* weight = nullptr;      // of all samples, by their number
};

// Writes color_r and, in the fourth column, sum_i w_i. Rays without active
// samples are black.
//   ray_color: num_rays x kRayColorWidth.
void CompositeColor(const ActiveColors& active,
                    size_t num_rays,
                    float* ray_color);

// From dL/dcolor_r the gradients by the weights, sum_c dL/dcolor_rc (c_ic -
// color_rc) / sum_j w_j, see CompositeGradients, and by what the sigmoid that
// gave the colours was taken of.
//   d_ray_color: num_rays x kRayColorWidth, the fourth column zero.
//   d_weight: of all samples; only those of active ones are written.
//   d_color: count x kColorOutputWidth; the fourth column gets zero, later ones
//     are left alone.
void CompositeColorBackward(const ActiveColors& active,
                            const float* ray_color,
                            const float* d_ray_color,
                            float* d_weight,
                            float* d_color);

}  // namespace structnerf
