#include "nerf/field/field_layout.h"

#include "nerf/util/random.h"

#include <algorithm>
#include <cmath>

namespace structnerf {
namespace {

constexpr float kInitialFeatureRange = 1e-2f;

GridLevel MakeLevel(const double cells_per_unit,
                    const Eigen::Vector3f& extent,
                    const int log2_table_size) {
  GridLevel level;
  level.cells_per_unit = static_cast<float>(cells_per_unit);
  uint64_t num_vertices = 1;
  for (int axis = 0; axis < 3; ++axis) {
    level.vertices[axis] =
        static_cast<uint32_t>(std::ceil(extent[axis] * cells_per_unit)) + 2;
    num_vertices *= level.vertices[axis];
  }
  const uint64_t table_size = uint64_t{1} << log2_table_size;
  level.hashed = num_vertices > table_size;
  level.num_entries =
      static_cast<uint32_t>(level.hashed ? table_size : num_vertices);
  return level;
}

void InitializeLayer(const LayerLayout& layer,
                     const float gain,
                     Random* random,
                     std::vector<float>* network) {
  const float range = gain * std::sqrt(6.0f / layer.num_inputs);
  for (int i = 0; i < layer.num_inputs * layer.num_outputs; ++i) {
    (*network)[layer.weights + i] = range * (2 * random->NextFloat() - 1);
  }
}

}  // namespace

LayerLayout AddLayer(const int num_inputs,
                     const int num_outputs,
                     size_t* num_parameters) {
  LayerLayout layer;
  layer.num_inputs = num_inputs;
  layer.num_outputs = num_outputs;
  layer.weights = *num_parameters;
  *num_parameters += static_cast<size_t>(num_inputs) * num_outputs;
  layer.biases = *num_parameters;
  *num_parameters += num_outputs;
  return layer;
}

FieldLayout::FieldLayout(const FieldOptions& options,
                         const Eigen::Vector3f& extent) {
  const int num_levels = options.num_levels;
  // A single level is the finest.
  const double min_resolution =
      num_levels == 1 ? options.max_resolution : options.min_resolution;
  const double growth = std::pow(options.max_resolution / min_resolution,
                                 1.0 / std::max(1, num_levels - 1));
  for (int i = 0; i < num_levels; ++i) {
    levels.push_back(MakeLevel(
        min_resolution * std::pow(growth, i), extent, options.log2_table_size));
    levels.back().first_entry = num_grid_entries;
    // Levels start at a multiple of eight entries, a whole number of cache
    // lines in every precision.
    num_grid_entries += (levels.back().num_entries + 7) / 8 * 8;
  }
  encoding_width = (num_levels * kGridFeatures + 15) / 16 * 16;
  hidden_width = options.hidden_width;
  num_harmonics =
      (options.direction_degree + 1) * (options.direction_degree + 1);
  density_hidden =
      AddLayer(encoding_width, hidden_width, &num_network_parameters);
  density_output =
      AddLayer(hidden_width, kGeometryWidth, &num_network_parameters);
  color_hidden =
      AddLayer(kColorInputWidth, hidden_width, &num_network_parameters);
  color_output =
      AddLayer(hidden_width, kColorOutputWidth, &num_network_parameters);
}

size_t FieldLayout::NumParameters() const {
  return num_grid_entries * kGridFeatures + num_network_parameters;
}

FieldParameters InitialParameters(const FieldLayout& layout,
                                  const float initial_density,
                                  const uint64_t seed) {
  FieldParameters parameters;
  Random random(seed);
  parameters.grid.resize(layout.num_grid_entries * kGridFeatures);
  for (float& feature : parameters.grid) {
    feature = kInitialFeatureRange * (2 * random.NextFloat() - 1);
  }
  parameters.network.assign(layout.num_network_parameters, 0.0f);
  InitializeLayer(layout.density_hidden, 1.0f, &random, &parameters.network);
  InitializeLayer(layout.density_output, 1.0f, &random, &parameters.network);
  InitializeLayer(layout.color_hidden, 1.0f, &random, &parameters.network);
  InitializeLayer(layout.color_output, 0.3f, &random, &parameters.network);
  parameters.network[layout.density_output.biases] = std::log(initial_density);
  return parameters;
}

}  // namespace structnerf
