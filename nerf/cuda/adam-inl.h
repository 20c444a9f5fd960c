#pragma once

#include "nerf/cuda/host_device.h"

#include <cmath>
#include <cstddef>
#include <cstdint>

namespace structnerf {

// The optimiser of nerf/kernels/adam.h.

struct DeviceAdam {
  float learning_rate;
  float beta1;
  float beta2;
  float epsilon;
  float max_gradient;  // from here on, a gradient is not finite

  STRUCTNERF_HOST_DEVICE bool IsFinite(const float gradient) const {
    return fabsf(gradient) < max_gradient;
  }

  STRUCTNERF_HOST_DEVICE void Update(const float gradient,
                                     float* first_moment,
                                     float* root_second_moment,
                                     float* value) const {
    const float m = *first_moment + (1 - beta1) * (gradient - *first_moment);
    const float v = beta2 * *root_second_moment * *root_second_moment +
                    (1 - beta2) * gradient * gradient;
    const float inverse_root = 1.0f / sqrtf(v + epsilon * epsilon);
    *first_moment = m;
    *root_second_moment = v * inverse_root;
    *value -= learning_rate * m * inverse_root;
  }
};

struct DeviceParameters {
  float* value;
  float* gradient;
  float* first_moment;
  float* root_second_moment;
};

// Call i updates the features of entry i, unless its gradient is zero, and
// clears its gradient. An entry whose gradient is not finite stays as it was,
// and `not_finite` is set.
struct AdamGridKernel {
  DeviceAdam adam;
  DeviceParameters parameters;
  uint32_t num_features;
  uint32_t* not_finite;

  STRUCTNERF_HOST_DEVICE void operator()(const size_t i) const {
    const size_t first = i * num_features;
    bool is_zero = true;
    bool is_finite = true;
    for (uint32_t f = 0; f < num_features; ++f) {
      const float gradient = parameters.gradient[first + f];
      is_zero = is_zero && gradient == 0;
      is_finite = is_finite && adam.IsFinite(gradient);
    }
    if (is_zero) {
      return;
    }
    for (uint32_t f = 0; f < num_features; ++f) {
      const size_t k = first + f;
      if (is_finite) {
        adam.Update(parameters.gradient[k],
                    parameters.first_moment + k,
                    parameters.root_second_moment + k,
                    parameters.value + k);
      }
      parameters.gradient[k] = 0;
    }
    if (!is_finite) {
      AtomicSet(not_finite);
    }
  }
};

// Sets `not_finite` if gradient i is not finite.
struct CheckGradientKernel {
  DeviceAdam adam;
  const float* gradient;
  uint32_t* not_finite;

  STRUCTNERF_HOST_DEVICE void operator()(const size_t i) const {
    if (!adam.IsFinite(gradient[i])) {
      AtomicSet(not_finite);
    }
  }
};

// Call i updates parameter i, unless `not_finite` is set, and clears its
// gradient.
struct AdamKernel {
  DeviceAdam adam;
  DeviceParameters parameters;
  const uint32_t* not_finite;

  STRUCTNERF_HOST_DEVICE void operator()(const size_t i) const {
    if (*not_finite == 0) {
      adam.Update(parameters.gradient[i],
                  parameters.first_moment + i,
                  parameters.root_second_moment + i,
                  parameters.value + i);
    }
    parameters.gradient[i] = 0;
  }
};

}  // namespace structnerf
