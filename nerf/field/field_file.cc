#include "nerf/field/field_file.h"

#include "nerf/util/checksummed_file.h"

#include <cstdint>
#include <cstring>
#include <stdexcept>

namespace structnerf {
namespace {

constexpr FileFormat kFormat = {
    {'S', 'N', 'F', 'I', 'E', 'L', 'D', '\0'}, /*version=*/2, "trained field"};

// Of the field; without padding, so that bytes can be compared.
struct Shape {
  uint64_t num_grid_values;
  uint64_t num_network_values;
  int32_t num_levels;
  int32_t log2_table_size;
  int32_t min_resolution;
  int32_t max_resolution;
  int32_t hidden_width;
  float extent[3];
};
static_assert(sizeof(Shape) == 2 * 8 + 8 * 4);

Shape MakeShape(const FieldOptions& options, const Eigen::Vector3f& extent) {
  const FieldLayout layout(options, extent);
  return {layout.num_grid_entries * kGridFeatures,
          layout.num_network_parameters,
          options.num_levels,
          options.log2_table_size,
          options.min_resolution,
          options.max_resolution,
          options.hidden_width,
          {extent.x(), extent.y(), extent.z()}};
}

}  // namespace

void WriteField(const std::string& path,
                const FieldOptions& options,
                const Eigen::Vector3f& extent,
                const FieldParameters& parameters) {
  ChecksummedFileWriter writer(kFormat, path);
  writer.WriteValue(MakeShape(options, extent));
  writer.Write(parameters.grid.data(), parameters.grid.size() * sizeof(float));
  writer.Write(parameters.network.data(),
               parameters.network.size() * sizeof(float));
  writer.Commit();
}

FieldParameters ReadField(const std::string& path,
                          const FieldOptions& options,
                          const Eigen::Vector3f& extent) {
  ChecksummedFileReader reader(kFormat, path);
  const Shape expected = MakeShape(options, extent);
  const auto shape = reader.ReadValue<Shape>();
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
