#include "nerf/engine/torch_field.h"

#include <torch/torch.h>

namespace structnerf {
namespace {

// As in nerf/kernels/grid_encoding.cc.
constexpr int64_t kPrimeY = 2654435761;
constexpr int64_t kPrimeZ = 805459861;

torch::Tensor Dense(const LayerLayout& layer,
                    const torch::Tensor& network,
                    const torch::Tensor& x) {
  const torch::Tensor weights =
      network
          .narrow(
              0, layer.weights, int64_t{layer.num_inputs} * layer.num_outputs)
          .view({layer.num_inputs, layer.num_outputs});
  return torch::addmm(
      network.narrow(0, layer.biases, layer.num_outputs), x, weights);
}

// Features of one level, samples x kGridFeatures.
torch::Tensor EncodeLevel(const GridLevel& level,
                          const torch::Tensor& grid,
                          const torch::Tensor& positions) {
  const torch::TensorOptions options = positions.options();
  const torch::Tensor last_cell =
      torch::tensor({static_cast<double>(level.vertices[0]) - 2,
                     static_cast<double>(level.vertices[1]) - 2,
                     static_cast<double>(level.vertices[2]) - 2},
                    options);
  const torch::Tensor scaled = torch::minimum(
      torch::clamp_min(positions * level.cells_per_unit, 0), last_cell);
  const torch::Tensor lower = scaled.floor();
  const torch::Tensor upper_weight = scaled - lower;
  const torch::Tensor cell = lower.to(torch::kInt64);

  const int64_t factor_y =
      level.hashed ? kPrimeY : static_cast<int64_t>(level.vertices[0]);
  const int64_t factor_z =
      level.hashed
          ? kPrimeZ
          : static_cast<int64_t>(level.vertices[0]) * level.vertices[1];
  std::vector<torch::Tensor> entries;
  std::vector<torch::Tensor> weights;
  for (int corner = 0; corner < 8; ++corner) {
    const int bits[3] = {corner & 1, (corner >> 1) & 1, corner >> 2};
    torch::Tensor terms[3];
    torch::Tensor weight;
    for (int axis = 0; axis < 3; ++axis) {
      terms[axis] = cell.select(1, axis) + bits[axis];
      const torch::Tensor upper = upper_weight.select(1, axis);
      const torch::Tensor factor = bits[axis] ? upper : 1 - upper;
      weight = axis == 0 ? factor : weight * factor;
    }
    terms[1] = terms[1] * factor_y;
    terms[2] = terms[2] * factor_z;
    entries.push_back(
        level.hashed
            ? torch::bitwise_and(
                  torch::bitwise_xor(terms[0],
                                     torch::bitwise_xor(terms[1], terms[2])),
                  static_cast<int64_t>(level.num_entries) - 1)
            : terms[0] + terms[1] + terms[2]);
    weights.push_back(weight);
  }
  const torch::Tensor entry =
      torch::stack(entries, 1) + static_cast<int64_t>(level.first_entry);
  const torch::Tensor features =
      grid.index_select(0, entry.flatten())
          .view({positions.size(0), 8, kGridFeatures});
  return (features * torch::stack(weights, 1).unsqueeze(2)).sum(1);
}

}  // namespace

torch::Tensor TorchEncode(const FieldLayout& layout,
                          const torch::Tensor& grid,
                          const torch::Tensor& positions,
                          const std::vector<float>& level_weights) {
  std::vector<torch::Tensor> parts;
  for (size_t i = 0; i < layout.levels.size(); ++i) {
    const float level_weight = level_weights.empty() ? 1.0f : level_weights[i];
    parts.push_back(EncodeLevel(layout.levels[i], grid, positions) *
                    level_weight);
  }
  const int64_t padding =
      layout.encoding_width -
      static_cast<int64_t>(layout.levels.size()) * kGridFeatures;
  if (padding > 0) {
    parts.push_back(
        torch::zeros({positions.size(0), padding}, positions.options()));
  }
  return torch::cat(parts, 1);
}

torch::Tensor TorchGeometry(const FieldLayout& layout,
                            const torch::Tensor& network,
                            const torch::Tensor& encoding) {
  return Dense(layout.density_output,
               network,
               torch::relu(Dense(layout.density_hidden, network, encoding)));
}

torch::Tensor TorchColor(const FieldLayout& layout,
                         const torch::Tensor& network,
                         const torch::Tensor& geometry,
                         const torch::Tensor& direction) {
  const torch::Tensor hidden = torch::relu(Dense(
      layout.color_hidden, network, torch::cat({geometry, direction}, 1)));
  return torch::sigmoid(
      Dense(layout.color_output, network, hidden).narrow(1, 0, 3));
}

}  // namespace structnerf
