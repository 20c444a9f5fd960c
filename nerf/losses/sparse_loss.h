#pragma once

#include "nerf/engine/ray_tile.h"

#include <string>

namespace structnerf {

// How the depth z of a sparse point acts on the ray through it. D is the
// rendered depth, w_i the share of the light that ends in interval i.
enum class SparseForm {
  // sum_i w_i ((z_i - z) / z)^2: all light is to end at the point, which also
  // clears the line of sight in front of it.
  kLineOfSight,

  // ((D - z) / unit)^2: the mean is to be at the point (paper, eq. 12; Deng et
  // al. 2022, "DS-NeRF", depth loss of the code).
  kSquared,

  // -sum_i P_i log w_i with P_i the share of a normal distribution around z in
  // interval i: up to a constant the Kullback-Leibler divergence of how light
  // ends from it (DS-NeRF, eq. 6-8, which takes the density at the samples
  // times
  // their distance for P_i; ours are unequally long).
  kRayTermination
};

// Of "line_of_sight", "squared" or "kl"; throws std::invalid_argument, listing
// them, for any other.
SparseForm SparseFormFromName(const std::string& name);

// A sparse point on a ray.
struct SparseTarget {
  float depth = 0;      // z, field units, > 0
  float deviation = 0;  // of the normal distribution, field units, > 0
  float weight = 0;     // of the term
};

// The first two forms at one ray: sets its derivatives by the weights
// (RayGradients::pull, of which a ray has one) or adds those by depth, and
// returns the weighted loss.
//   unit: length that differences of depth are measured in, field units.
float EvaluateLineOfSight(const SparseTarget& target,
                          const RayOutputs& outputs,
                          int ray,
                          RayGradients* gradients);
float EvaluateSquaredDepth(const SparseTarget& target,
                           float unit,
                           const RayOutputs& outputs,
                           int ray,
                           RayGradients* gradients);

// The third form. Adds derivatives by the weights to those of all rays. A
// weight of zero costs -log(1e-5) (as in DS-NeRF's code) of its share.
float EvaluateRayTermination(const SparseTarget& target,
                             const RaySamples& samples,
                             int ray,
                             float* d_weight);

}  // namespace structnerf
