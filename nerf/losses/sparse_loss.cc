#include "nerf/losses/sparse_loss.h"

#include <cmath>
#include <stdexcept>

namespace structnerf {
namespace {

// Keeps the logarithm of a weight and its derivative finite.
constexpr float kMinWeight = 1e-5f;

// Distribution function of the normal distribution.
float NormalShareBelow(const float x) {
  return 0.5f * std::erfc(-x * static_cast<float>(M_SQRT1_2));
}

}  // namespace

SparseForm SparseFormFromName(const std::string& name) {
  if (name == "line_of_sight") {
    return SparseForm::kLineOfSight;
  } else if (name == "squared") {
    return SparseForm::kSquared;
  } else if (name == "kl") {
    return SparseForm::kRayTermination;
  }
  throw std::invalid_argument(
      "sparse_form must be line_of_sight, squared or kl, but is \"" + name +
      "\"");
}

float EvaluateLineOfSight(const SparseTarget& target,
                          const RayOutputs& outputs,
                          const int ray,
                          RayGradients* gradients) {
  gradients->pull[ray] = target.weight;
  gradients->pull_z[ray] = target.depth;
  const float offset = (outputs.depth[ray] - target.depth) / target.depth;
  const float spread =
      outputs.depth_variance[ray] / (target.depth * target.depth);
  return target.weight * (offset * offset + spread);
}

float EvaluateSquaredDepth(const SparseTarget& target,
                           const float unit,
                           const RayOutputs& outputs,
                           const int ray,
                           RayGradients* gradients) {
  const float offset = (outputs.depth[ray] - target.depth) / unit;
  gradients->d_depth[ray] += 2 * target.weight * offset / unit;
  return target.weight * offset * offset;
}

float EvaluateRayTermination(const SparseTarget& target,
                             const RaySamples& samples,
                             const int ray,
                             float* d_weight) {
  const int n = samples.num_samples;
  const float* const edges = samples.edges + ray * (n + 1);
  const float* const weight = samples.weight + ray * n;
  float loss = 0;
  float below = 0;  // share in front of the interval
  for (int i = 0; i < n; ++i) {
    // What lies beyond the ray's ends counts for its outer intervals.
    const float up_to = i == n - 1
                            ? 1.0f
                            : NormalShareBelow((edges[i + 1] - target.depth) /
                                               target.deviation);
    const float share = target.weight * (up_to - below);
    below = up_to;
    loss -= share * std::log(weight[i] + kMinWeight);
    d_weight[ray * n + i] -= share / (weight[i] + kMinWeight);
  }
  return loss;
}

}  // namespace structnerf
