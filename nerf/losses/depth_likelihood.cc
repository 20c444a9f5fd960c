#include "nerf/losses/depth_likelihood.h"

#include <cmath>

namespace structnerf {
namespace {

// Smallest deviation, in units.
constexpr float kMinDeviation = 1e-3f;

}  // namespace

float EvaluateDepthLikelihood(const PriorDepth& prior,
                              const float weight,
                              const float unit,
                              const RayOutputs& outputs,
                              const int ray,
                              RayGradients* gradients) {
  const float depth = outputs.depth[ray];
  const float offset = (depth - prior.depth) / unit;
  const float rendered_variance = outputs.depth_variance[ray] / (unit * unit);
  const float deviation = prior.deviation / unit;
  if (std::abs(offset) <= deviation &&
      rendered_variance <= deviation * deviation) {
    return 0;
  }
  constexpr float kMinVariance = kMinDeviation * kMinDeviation;
  const float variance = rendered_variance + kMinVariance;
  const float ratio = offset / variance;
  gradients->d_depth[ray] += 2 * weight * ratio / unit;
  const float d_variance = weight * (1 / variance - ratio * ratio);
  gradients->pull[ray] = d_variance * depth * depth / (unit * unit);
  gradients->pull_z[ray] = depth;
  return weight * (std::log(variance) + offset * ratio);
}

}  // namespace structnerf
