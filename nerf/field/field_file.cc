#include "nerf/field/field_file.h"

#include "nerf/field/mlp_layout.h"
#include "nerf/util/checksummed_file.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <stdexcept>

namespace structnerf {
namespace {

constexpr FileFormat kFormat = {
    {'S', 'N', 'F', 'I', 'E', 'L', 'D', '\0'}, /*version=*/4, "trained field"};

// Of the field; without padding, so that bytes can be compared.
struct Shape {
  uint64_t num_grid_values;
  uint64_t num_network_values;
  int32_t num_levels;
  int32_t log2_table_size;
  int32_t min_resolution;
  int32_t max_resolution;
  int32_t hidden_width;
  int32_t mlp_num_layers;  // 0 = a grid
  int32_t mlp_width;
  int32_t latent_size;
  float extent[3];
  int32_t direction_degree;
};
static_assert(sizeof(Shape) == 2 * 8 + 12 * 4);

Shape MakeShape(const FieldOptions& options, const Eigen::Vector3f& extent) {
  Shape shape;
  std::memset(&shape, 0, sizeof(shape));
  std::copy(extent.data(), extent.data() + 3, shape.extent);
  if (options.type == "mlp") {
    shape.num_network_values = 2 * MlpLayout(options).num_parameters;
    shape.mlp_num_layers = options.mlp_num_layers;
    shape.mlp_width = options.mlp_width;
    shape.latent_size = options.latent_size;
    return shape;
  }
  const FieldLayout layout(options, extent);
  shape.num_grid_values = layout.num_grid_entries * kGridFeatures;
  shape.num_network_values = layout.num_network_parameters;
  shape.num_levels = options.num_levels;
  shape.log2_table_size = options.log2_table_size;
  shape.min_resolution = options.min_resolution;
  shape.max_resolution = options.max_resolution;
  shape.hidden_width = options.hidden_width;
  shape.direction_degree = options.direction_degree;
  return shape;
}

}  // namespace

void WriteField(const std::string& path,
                const FieldOptions& options,
                const Eigen::Vector3f& extent,
                const FieldParameters& parameters) {
  ChecksummedFileWriter writer(kFormat, path);
  Shape shape = MakeShape(options, extent);
  // Latent codes come on top, as many as there were photographs.
  shape.num_network_values = parameters.network.size();
  writer.WriteValue(shape);
  writer.Write(parameters.grid.data(), parameters.grid.size() * sizeof(float));
  writer.Write(parameters.network.data(),
               parameters.network.size() * sizeof(float));
  writer.Commit();
}

FieldParameters ReadField(const std::string& path,
                          const FieldOptions& options,
                          const Eigen::Vector3f& extent) {
  ChecksummedFileReader reader(kFormat, path);
  Shape expected = MakeShape(options, extent);
  const auto shape = reader.ReadValue<Shape>();
  if (expected.latent_size > 0 &&
      shape.num_network_values > expected.num_network_values &&
      (shape.num_network_values - expected.num_network_values) %
              expected.latent_size ==
          0) {
    expected.num_network_values = shape.num_network_values;
  }
  if (std::memcmp(&shape, &expected, sizeof(shape)) != 0) {
    throw std::runtime_error(
        path + " was trained with other field options or on another scene");
  }
  FieldParameters parameters;
  parameters.grid.resize(shape.num_grid_values);
  parameters.network.resize(shape.num_network_values);
  reader.Read(parameters.grid.data(), parameters.grid.size() * sizeof(float));
  reader.Read(parameters.network.data(),
              parameters.network.size() * sizeof(float));
  return parameters;
}

}  // namespace structnerf
