#pragma once

#include "nerf/kernels/compositing.h"

#include <cstddef>
#include <vector>

namespace structnerf {

// Inputs of CompositeForward, in memory of their own.
struct CompositeRays {
  CompositeRays(size_t num_rays, size_t num_samples);
  CompositeInputs Inputs() const;

  size_t num_rays = 0;
  size_t num_samples = 0;
  std::vector<float> raw_density;  // num_rays x num_samples
  std::vector<float> edges;        // num_rays x (num_samples + 1)
  std::vector<float> ray_length;   // num_rays
};

struct CompositeResult {
  std::vector<float> tau;
  std::vector<float> transmittance;
  std::vector<float> weight;
  std::vector<float> z;
  std::vector<float> depth;
  std::vector<float> depth_variance;
  std::vector<float> opacity;
};

CompositeResult Composite(const CompositeRays& rays);

// dL/draw_density for L = sum over rays of d_depth * depth plus the pull of
// `pull` to `pull_z`, see CompositeGradients.
std::vector<float> CompositeGradient(const CompositeRays& rays,
                                     CompositeResult result,
                                     float d_depth,
                                     float pull,
                                     float pull_z);

// The formulas of nerf/kernels/compositing.h once more, in double.
struct DoubleRay {
  std::vector<double> weight;
  std::vector<double> z;
  double depth = 0;
};

DoubleRay CompositeInDouble(const CompositeRays& rays, size_t ray);

// L of one ray, in double.
double CompositeLossInDouble(const CompositeRays& rays,
                             size_t ray,
                             double d_depth,
                             double pull,
                             double pull_z);

}  // namespace structnerf
