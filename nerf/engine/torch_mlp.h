#pragma once

#include "nerf/field/mlp_layout.h"

#include <vector>

#include <torch/types.h>

namespace structnerf {

// One of NeRF's networks on tensors, which may be leaves of autograd: for each
// of MlpLayout::Layers() the weights, inputs x outputs, and the biases.
struct TorchMlp {
  std::vector<torch::Tensor> weights;
  std::vector<torch::Tensor> biases;
};

// From `values`, a vector of layout.num_parameters numbers, which are copied.
TorchMlp MakeTorchMlp(const MlpLayout& layout, const torch::Tensor& values);

// (x, sin(2^k pi x), cos(2^k pi x)) for k < num_frequencies.
//   x: samples x 3. Returns samples x EncodingWidth(num_frequencies).
torch::Tensor EncodeFrequencies(const torch::Tensor& x, int num_frequencies);

struct TorchMlpOutput {
  torch::Tensor raw_density;  // samples; log density per field unit
  torch::Tensor color;        // samples x 3, in [0, 1]; undefined if unwanted
};

// The field at some points. Density is rectified, as NeRF's, in the
// network's units (nerf/field/mlp_layout.h), but never less than what
// nerf/kernels/compositing.h takes for nothing.
//   positions: samples x 3, field coordinates. extent: 3, of the scene box.
//   directions: samples x 3, of unit length; undefined if no colour is wanted.
//   codes: samples x latent_size; read for colour only, and if that is not 0.
TorchMlpOutput EvaluateTorchMlp(const MlpLayout& layout,
                                const TorchMlp& mlp,
                                const torch::Tensor& positions,
                                const torch::Tensor& extent,
                                const torch::Tensor& directions,
                                const torch::Tensor& codes);

}  // namespace structnerf
