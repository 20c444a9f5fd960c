#include "nerf/field/mlp_layout.h"

#include "nerf/util/random.h"

#include <cmath>

namespace structnerf {

MlpLayout::MlpLayout(const FieldOptions& options) {
  const auto add_layer = [&](const int num_inputs, const int num_outputs) {
    return AddLayer(num_inputs, num_outputs, &num_parameters);
  };
  latent_size = options.latent_size;
  const int width = options.mlp_width;
  const int position_width = EncodingWidth(kPositionFrequencies);
  skip_layer = options.mlp_num_layers / 2 + 1;
  for (int i = 0; i < options.mlp_num_layers; ++i) {
    const int num_inputs = i == 0            ? position_width
                           : i == skip_layer ? width + position_width
                                             : width;
    trunk.push_back(add_layer(num_inputs, width));
  }
  density = add_layer(width, 1);
  feature = add_layer(width, width);
  color_hidden = add_layer(
      width + EncodingWidth(kDirectionFrequencies) + latent_size, width / 2);
  color_output = add_layer(width / 2, 3);
}

std::vector<LayerLayout> MlpLayout::Layers() const {
  std::vector<LayerLayout> layers = trunk;
  layers.insert(layers.end(), {density, feature, color_hidden, color_output});
  return layers;
}

std::vector<float> InitialMlpParameters(const MlpLayout& layout,
                                        const int num_codes,
                                        const float initial_density,
                                        const uint64_t seed) {
  std::vector<float> parameters(2 * layout.num_parameters +
                                static_cast<size_t>(num_codes) *
                                    layout.latent_size);
  for (size_t network = 0; network < 2; ++network) {
    Random random(seed, network);
    float* const values = parameters.data() + network * layout.num_parameters;
    for (const LayerLayout& layer : layout.Layers()) {
      const float range =
          1.0f / std::sqrt(static_cast<float>(layer.num_inputs));
      const size_t end = layer.biases + layer.num_outputs;
      for (size_t i = layer.weights; i < end; ++i) {
        values[i] = range * (2 * random.NextFloat() - 1);
      }
    }
    values[layout.density.biases] = initial_density / kMlpUnitsPerFieldUnit;
  }
  return parameters;
}

}  // namespace structnerf
