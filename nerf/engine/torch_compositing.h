#pragma once

#include <torch/types.h>

namespace structnerf {

// Volume rendering in tensor operations, with the formulas of
// nerf/kernels/compositing.h.
struct TorchComposite {
  torch::Tensor weight;    // rays x n
  torch::Tensor z;         // rays x n, z-depth at which light ends in the mean
  torch::Tensor depth;     // rays
  torch::Tensor variance;  // rays
  torch::Tensor opacity;   // rays
};

//   raw_density: rays x n.
//   edges: rays x (n + 1), z-depth, ascending.
//   ray_length: rays, length per unit of z-depth.
TorchComposite CompositeWithTorch(const torch::Tensor& raw_density,
                                  const torch::Tensor& edges,
                                  const torch::Tensor& ray_length);

// Colour of the rays, rays x 3: the mean of the samples' colours by weight,
// without samples of less weight than `min_color_weight`.
//   weight: rays x n. color: rays x n x 3.
torch::Tensor RayColorWithTorch(const torch::Tensor& weight,
                                const torch::Tensor& color,
                                double min_color_weight);

// The line-of-sight term of each ray, sum_i w_i ((z_i - pull_z) / pull_z)^2,
// zero where pull is zero; rays.
torch::Tensor PullWithTorch(const TorchComposite& composite,
                            const torch::Tensor& pull,
                            const torch::Tensor& pull_z);

}  // namespace structnerf
