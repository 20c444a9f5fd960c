#include "nerf/engine/torch_mlp.h"

#include "nerf/kernels/compositing.h"

#include <cmath>

#include <torch/torch.h>

namespace structnerf {

TorchMlp MakeTorchMlp(const MlpLayout& layout, const torch::Tensor& values) {
  TorchMlp mlp;
  for (const LayerLayout& layer : layout.Layers()) {
    const int64_t num_weights =
        static_cast<int64_t>(layer.num_inputs) * layer.num_outputs;
    mlp.weights.push_back(
        values.narrow(0, static_cast<int64_t>(layer.weights), num_weights)
            .view({layer.num_inputs, layer.num_outputs})
            .clone());
    mlp.biases.push_back(
        values.narrow(0, static_cast<int64_t>(layer.biases), layer.num_outputs)
            .clone());
  }
  return mlp;
}

torch::Tensor EncodeFrequencies(const torch::Tensor& x,
                                const int num_frequencies) {
  std::vector<torch::Tensor> columns = {x};
  for (int k = 0; k < num_frequencies; ++k) {
    const torch::Tensor scaled = x * (std::ldexp(1.0, k) * M_PI);
    columns.push_back(torch::sin(scaled));
    columns.push_back(torch::cos(scaled));
  }
  return torch::cat(columns, 1);
}

TorchMlpOutput EvaluateTorchMlp(const MlpLayout& layout,
                                const TorchMlp& mlp,
                                const torch::Tensor& positions,
                                const torch::Tensor& extent,
                                const torch::Tensor& directions,
                                const torch::Tensor& codes) {
  // The next of Layers().
  size_t layer_idx = 0;
  const auto apply = [&](const torch::Tensor& input) {
    const torch::Tensor output =
        torch::addmm(mlp.biases[layer_idx], input, mlp.weights[layer_idx]);
    ++layer_idx;
    return output;
  };
  const torch::Tensor encoding = EncodeFrequencies(
      kMlpUnitsPerFieldUnit * positions - extent, kPositionFrequencies);
  torch::Tensor hidden = encoding;
  for (int i = 0; i < static_cast<int>(layout.trunk.size()); ++i) {
    if (i == layout.skip_layer) {
      hidden = torch::cat({encoding, hidden}, 1);
    }
    hidden = torch::relu(apply(hidden));
  }
  TorchMlpOutput output;
  output.raw_density = torch::log(
      torch::clamp_min(kMlpUnitsPerFieldUnit * apply(hidden).squeeze(1),
                       std::exp(kMinRawDensity)));
  if (!directions.defined()) {
    return output;
  }
  const torch::Tensor feature = apply(hidden);
  std::vector<torch::Tensor> color_inputs = {
      feature, EncodeFrequencies(directions, kDirectionFrequencies)};
  if (layout.latent_size > 0) {
    color_inputs.push_back(codes);
  }
  const torch::Tensor color_hidden =
      torch::relu(apply(torch::cat(color_inputs, 1)));
  output.color = torch::sigmoid(apply(color_hidden));
  return output;
}

}  // namespace structnerf
