#pragma once

#include "nerf/field/field_layout.h"

#include <vector>

#include <torch/types.h>

namespace structnerf {

// The radiance field in tensor operations. Parameters are shaped as in
// FieldParameters: grid is num_grid_entries x kGridFeatures, network a vector;
// all tensors of a call have the same floating point type.

// Interpolated features of the points, samples x encoding_width.
//   positions: samples x 3, field coordinates.
//   level_weights: factor on each level's features; empty = all one.
torch::Tensor TorchEncode(const FieldLayout& layout,
                          const torch::Tensor& grid,
                          const torch::Tensor& positions,
                          const std::vector<float>& level_weights);

// Output of the density network, samples x kGeometryWidth. Column 0 is the raw
// log density.
torch::Tensor TorchGeometry(const FieldLayout& layout,
                            const torch::Tensor& network,
                            const torch::Tensor& encoding);

// Colours in [0, 1], samples x 3.
//   direction: samples x kDirectionWidth, see EncodeDirection.
torch::Tensor TorchColor(const FieldLayout& layout,
                         const torch::Tensor& network,
                         const torch::Tensor& geometry,
                         const torch::Tensor& direction);

}  // namespace structnerf
