#pragma once

#include "nerf/engine/ray_tile.h"

namespace structnerf {

// What a depth prior says about a ray.
struct PriorDepth {
  float depth = 0;      // field units; 0 = nothing
  float deviation = 0;  // field units, > 0
};

// Negative log likelihood of a prior's depth d, up to a constant and factor, if
// the depth at which light ends is normal with what is rendered as its mean D
// and variance V:
//   log(V) + (D - d)^2 / V, where |D - d| or the root of V exceeds the prior's
//   deviation; nothing else is known of the ray
// (Roessle et al. 2022, "Dense Depth Priors for Neural Radiance Fields", eq.
// 6-7). V is that of the rendered ray plus (1e-3 units)^2, or a ray that has
// come to a point would gain without end by getting sharper.
//
// Adds derivatives and returns the weighted loss. That by the variance is
// expressed as a pull (RayGradients) towards D, so the ray must have no other.
float EvaluateDepthLikelihood(const PriorDepth& prior,
                              float weight,
                              float unit,
                              const RayOutputs& outputs,
                              int ray,
                              RayGradients* gradients);

}  // namespace structnerf
