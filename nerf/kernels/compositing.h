#pragma once

#include <cstddef>

namespace structnerf {

// Numerically integrated volume rendering of one tile of rays (Mildenhall et
// al. 2020, eq. 3, in optical thickness). Ray r has the intervals
// [edges[r * (n + 1) + i], edges[r * (n + 1) + i + 1]), i < n, with constant
// density in each; arrays over samples are ray-major, index r * n + i.
//
// tau = sigma * (interval length), T_i = exp(-sum_{j<i} tau_j),
// w_i = T_i (1 - exp(-tau_i)), and the last interval is opaque, w_{n-1} =
// T_{n-1}: weights of a ray sum to one and no result is divided by opacity.
//
// Within an interval light ends, in the mean, at
//   z_i = edge_i + length * f(tau_i),  f(tau) = 1 / tau - 1 / (exp(tau) - 1),
// and at the middle of the last one. Midpoints instead would put an opaque
// surface half an interval too far.

// Density is exp(raw) with raw clamped to this range; outside, its gradient is
// zero. Field coordinates have unit size, so the upper end is a mean free path
// of 1e-5 of the scene.
constexpr float kMinRawDensity = -12.0f;
constexpr float kMaxRawDensity = 12.0f;

struct CompositeInputs {
  size_t num_rays = 0;
  size_t num_samples = 0;              // n, per ray
  const float* raw_density = nullptr;  // rays x n
  size_t raw_density_stride = 1;       // floats between samples
  const float* edges = nullptr;        // rays x (n + 1), z-depth, ascending
  const float* ray_length = nullptr;   // rays, length per unit of z-depth
};

// Per sample, rays x n each.
struct CompositeSamples {
  float* tau = nullptr;
  float* transmittance = nullptr;  // T_i
  float* weight = nullptr;         // w_i
  float* z = nullptr;              // z_i
};

// Fills `samples`, and per ray the depth sum w z, its variance sum w (z -
// depth)^2 and the opacity 1 - T_{n-1}.
void CompositeForward(const CompositeInputs& inputs,
                      const CompositeSamples& samples,
                      float* depth,
                      float* depth_variance,
                      float* opacity);

// Gradients of the loss with respect to one ray's results. Besides depth and
// opacity a loss may pull the whole distribution to a depth, adding
// pull * sum_i w_i ((z_i - pull_z) / pull_z)^2 for pull_z > 0 (line of sight).
struct CompositeGradients {
  const float* depth = nullptr;      // rays, as rendered
  const float* d_depth = nullptr;    // rays
  const float* d_opacity = nullptr;  // rays
  const float* pull = nullptr;       // rays, 0 = no pull
  const float* pull_z = nullptr;     // rays
  // sum_k dL/dcolor_k (color_ik - color_k): derivative by the weight through
  // colour. Since weights sum to one, a constant per ray makes no difference;
  // this one keeps differences of large numbers out of the sums.
  const float* d_weight_color = nullptr;  // rays x n
};

// Writes dL/draw_density, rays x n.
void CompositeBackward(const CompositeInputs& inputs,
                       const CompositeSamples& samples,
                       const CompositeGradients& gradients,
                       float* d_raw_density);

}  // namespace structnerf
