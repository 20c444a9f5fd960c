#pragma once

#include "nerf/cuda/host_device.h"
#include "nerf/kernels/compositing.h"

#include <cmath>
#include <cstddef>
#include <cstdint>

namespace structnerf {

// Volume rendering of nerf/kernels/compositing.h and color_compositing.h, one
// call per ray or sample.

// f(tau) and f'(tau) of nerf/kernels/compositing.h.
STRUCTNERF_HOST_DEVICE inline float WithinInterval(const float tau,
                                                   float* derivative) {
  // Below, the closed forms cancel; the series are exact to float precision.
  constexpr float kSeriesTau = 0.3f;
  if (tau < kSeriesTau) {
    const float tau2 = tau * tau;
    *derivative =
        ((5.7870370e-6f * tau2 - 1.6534392e-4f) * tau2 + 4.1666667e-3f) * tau2 -
        8.3333333e-2f;
    return (((8.2671958e-7f * tau2 - 3.3068783e-5f) * tau2 + 1.3888889e-3f) *
                tau2 -
            8.3333333e-2f) *
               tau +
           0.5f;
  }
  const float inverse_tau = 1.0f / tau;
  const float u = expf(-tau);
  const float inverse = 1.0f / (1.0f - u);
  *derivative = u * inverse * inverse - inverse_tau * inverse_tau;
  return inverse_tau - u * inverse;
}

// Call i does ray i.
struct CompositeForwardKernel {
  CompositeInputs inputs;
  CompositeSamples samples;
  float* depth;
  float* depth_variance;
  float* opacity;

  STRUCTNERF_HOST_DEVICE void operator()(const size_t ray) const {
    const size_t n = inputs.num_samples;
    const float* const edges = inputs.edges + ray * (n + 1);
    float* const tau = samples.tau + ray * n;
    float* const transmittance = samples.transmittance + ray * n;
    float* const weight = samples.weight + ray * n;
    float* const z = samples.z + ray * n;
    float thickness = 0;
    float mean = 0;
    for (size_t i = 0; i < n; ++i) {
      const float raw =
          inputs.raw_density[(ray * n + i) * inputs.raw_density_stride];
      const float length = edges[i + 1] - edges[i];
      tau[i] = expf(fminf(fmaxf(raw, kMinRawDensity), kMaxRawDensity)) *
               (length * inputs.ray_length[ray]);
      transmittance[i] = expf(-thickness);
      thickness += tau[i];
      if (i + 1 < n) {
        float derivative;
        weight[i] = transmittance[i] * -expm1f(-tau[i]);
        z[i] = edges[i] + length * WithinInterval(tau[i], &derivative);
      } else {
        weight[i] = transmittance[i];
        z[i] = 0.5f * (edges[i] + edges[i + 1]);
      }
      mean += weight[i] * z[i];
    }
    float variance = 0;
    for (size_t i = 0; i < n; ++i) {
      variance += weight[i] * (z[i] - mean) * (z[i] - mean);
    }
    depth[ray] = mean;
    depth_variance[ray] = variance;
    opacity[ray] = 1.0f - transmittance[n - 1];
  }
};

// Call i does ray i.
struct CompositeBackwardKernel {
  CompositeInputs inputs;
  CompositeSamples samples;
  CompositeGradients gradients;
  float* d_raw_density;  // rays x n

  STRUCTNERF_HOST_DEVICE void operator()(const size_t ray) const {
    const size_t n = inputs.num_samples;
    const float depth = gradients.depth[ray];
    const float d_depth = gradients.d_depth[ray];
    const float pull_z =
        gradients.pull[ray] != 0 ? gradients.pull_z[ray] : 1.0f;
    const float pull = gradients.pull[ray] / (pull_z * pull_z);
    // From the back, so that the sum over later samples is never a difference
    // of large numbers.
    float later = 0;  // sum_{j > i} w_j dL/dw_j
    for (size_t i = n; i-- > 0;) {
      const size_t s = ray * n + i;
      const float z = samples.z[s];
      const float weight = samples.weight[s];
      const float d_weight =
          gradients.d_weight_color[s] +
          (z - depth) * (d_depth + pull * ((z - pull_z) + (depth - pull_z)));
      if (i + 1 == n) {
        later = weight * (d_weight - gradients.d_opacity[ray]);
        d_raw_density[s] = 0;
        continue;
      }
      const float d_z = weight * (d_depth + 2 * pull * (z - pull_z));
      const float* const edges = inputs.edges + ray * (n + 1) + i;
      float z_by_tau;
      WithinInterval(samples.tau[s], &z_by_tau);
      const float d_tau = samples.transmittance[s + 1] * d_weight - later +
                          d_z * (edges[1] - edges[0]) * z_by_tau;
      const float raw = inputs.raw_density[s * inputs.raw_density_stride];
      const bool is_clamped = raw < kMinRawDensity || raw > kMaxRawDensity;
      d_raw_density[s] = is_clamped ? 0.0f : d_tau * samples.tau[s];
      later += weight * d_weight;
    }
  }
};

// Colours of samples and rays. Samples of less weight than `min_weight` have
// none.
struct DeviceColors {
  uint32_t num_samples;  // n, per ray
  const float* weight;   // rays x n
  const float* color;    // rays x n x 3, in [0, 1]
  float min_weight;

  STRUCTNERF_HOST_DEVICE bool IsActive(const size_t sample) const {
    return weight[sample] >= min_weight;
  }
};

// Call i writes the colour of ray i and the sum of its weights, rays x 4.
struct CompositeColorKernel {
  DeviceColors colors;
  float* ray_color;

  STRUCTNERF_HOST_DEVICE void operator()(const size_t ray) const {
    float sums[4] = {};
    const size_t n = colors.num_samples;
    for (size_t s = ray * n; s < (ray + 1) * n; ++s) {
      if (colors.IsActive(s)) {
        for (size_t c = 0; c < 3; ++c) {
          sums[c] += colors.weight[s] * colors.color[s * 3 + c];
        }
        sums[3] += colors.weight[s];
      }
    }
    for (size_t c = 0; c < 3; ++c) {
      ray_color[ray * 4 + c] = sums[3] != 0 ? sums[c] / sums[3] : 0.0f;
    }
    ray_color[ray * 4 + 3] = sums[3];
  }
};

// Call i writes the derivatives by the weight of sample i, adding what is in
// `d_weight`, and by its colour before the sigmoid.
struct CompositeColorBackwardKernel {
  DeviceColors colors;
  const float* ray_color;    // rays x 4
  const float* d_ray_color;  // rays x 3
  const float* d_weight;     // rays x n, further ones, or null
  float* d_weight_color;     // rays x n
  float* d_color;            // rays x n x 3

  STRUCTNERF_HOST_DEVICE void operator()(const size_t s) const {
    const size_t ray = s / colors.num_samples;
    const bool is_active = colors.IsActive(s);
    const float share = is_active ? 1.0f / ray_color[ray * 4 + 3] : 0.0f;
    float d_weight_sum = d_weight != nullptr ? d_weight[s] : 0.0f;
    for (size_t c = 0; c < 3; ++c) {
      const float color = colors.color[s * 3 + c];
      const float gradient = share * d_ray_color[ray * 3 + c];
      d_weight_sum += gradient * (color - ray_color[ray * 4 + c]);
      d_color[s * 3 + c] =
          colors.weight[s] * gradient * (color * (1.0f - color));
    }
    d_weight_color[s] = d_weight_sum;
  }
};

}  // namespace structnerf
