#pragma once

#include "nerf/engine/ray_tile.h"
#include "nerf/engine/torch_compositing.h"

#include <vector>

#include <torch/types.h>

namespace structnerf {

// What the engines in tensor operations share: copies between tensors and plain
// memory, and the way from an objective's derivatives to autograd.

// A copy of the values as a vector of the given type.
torch::Tensor MakeTensor(const std::vector<float>& values,
                         torch::ScalarType type);

// The values, row-major.
std::vector<float> CopyValues(const torch::Tensor& values);

// Whether a gradient may be used, element by element.
torch::Tensor IsFiniteGradient(const torch::Tensor& gradient);

// Rays of several tiles, one after the other.
struct RenderedBatch {
  torch::Tensor raw_density;  // rays x n
  TorchComposite composite;
  torch::Tensor color;  // rays x 3, undefined if not asked for
};

// Of the batch's rays [first_ray, first_ray + num_rays).
void CopyOutputs(const RenderedBatch& rendered,
                 int64_t first_ray,
                 int64_t num_rays,
                 RayOutputs* outputs);

// Collects what objectives say about the rays of a batch.
class OutputGradients {
 public:
  // Of the next `num_rays` rays.
  void Append(const RayGradients& gradients, int num_rays);

  // The same, colour only.
  void AppendColor(const RayGradients& gradients, int num_rays);

  // A function of the batch whose derivatives by its outputs are those
  // collected.
  torch::Tensor Surrogate(const RenderedBatch& rendered) const;

 private:
  // Columns of RayGradients.
  static constexpr int kNumColumns = 7;
  std::vector<float> columns_[kNumColumns];
};

}  // namespace structnerf
