#include "nerf/field/field_file.h"

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <vector>

namespace structnerf {
namespace {

struct Header {
  char magic[8];
  uint32_t version;
  int32_t num_levels;
  int32_t log2_table_size;
  int32_t min_resolution;
  int32_t max_resolution;
  int32_t hidden_width;
  float extent[3];
  uint32_t padding;
  uint64_t num_grid_values;
  uint64_t num_network_values;
};

constexpr char kMagic[8] = {'S', 'N', 'F', 'I', 'E', 'L', 'D', '\0'};
constexpr uint32_t kVersion = 1;

Header MakeHeader(const FieldOptions& options, const Eigen::Vector3f& extent) {
  Header header;
  std::memset(&header, 0, sizeof(header));
  std::memcpy(header.magic, kMagic, sizeof(kMagic));
  header.version = kVersion;
  header.num_levels = options.num_levels;
  header.log2_table_size = options.log2_table_size;
  header.min_resolution = options.min_resolution;
  header.max_resolution = options.max_resolution;
  header.hidden_width = options.hidden_width;
  std::copy(extent.data(), extent.data() + 3, header.extent);
  const FieldLayout layout(options, extent);
  header.num_grid_values = layout.num_grid_entries * kGridFeatures;
  header.num_network_values = layout.num_network_parameters;
  return header;
}

// FNV-1a over 64-bit words, the rest byte by byte.
uint64_t Checksum(const void* data, const size_t size, uint64_t hash) {
  constexpr uint64_t kPrime = 1099511628211ULL;
  const char* const bytes = static_cast<const char*>(data);
  size_t i = 0;
  for (; i + 8 <= size; i += 8) {
    uint64_t word;
    std::memcpy(&word, bytes + i, 8);
    hash = (hash ^ word) * kPrime;
  }
  for (; i < size; ++i) {
    hash = (hash ^ static_cast<unsigned char>(bytes[i])) * kPrime;
  }
  return hash;
}

uint64_t FileChecksum(const Header& header, const FieldParameters& parameters) {
  uint64_t hash = 14695981039346656037ULL;
  hash = Checksum(&header, sizeof(header), hash);
  hash = Checksum(
      parameters.grid.data(), parameters.grid.size() * sizeof(float), hash);
  return Checksum(parameters.network.data(),
                  parameters.network.size() * sizeof(float),
                  hash);
}

}  // namespace

void WriteField(const std::string& path,
                const FieldOptions& options,
                const Eigen::Vector3f& extent,
                const FieldParameters& parameters) {
  const Header header = MakeHeader(options, extent);
  const uint64_t checksum = FileChecksum(header, parameters);
  const std::string partial_path = path + ".partial";
  {
    std::ofstream file(partial_path, std::ios::binary | std::ios::trunc);
    file.write(reinterpret_cast<const char*>(&header), sizeof(header));
    file.write(reinterpret_cast<const char*>(parameters.grid.data()),
               parameters.grid.size() * sizeof(float));
    file.write(reinterpret_cast<const char*>(parameters.network.data()),
               parameters.network.size() * sizeof(float));
    file.write(reinterpret_cast<const char*>(&checksum), sizeof(checksum));
    file.close();
    if (!file) {
      std::error_code ignored;
      std::filesystem::remove(partial_path, ignored);
      throw std::runtime_error("could not write the trained field to " + path +
                               "; is the disk full or read-only?");
    }
  }
  std::error_code error;
  std::filesystem::rename(partial_path, path, error);
  if (error) {
    std::error_code ignored;
    std::filesystem::remove(partial_path, ignored);
    throw std::runtime_error("could not write the trained field to " + path +
                             ": " + error.message());
  }
}

FieldParameters ReadField(const std::string& path,
                          const FieldOptions& options,
                          const Eigen::Vector3f& extent) {
  std::ifstream file(path, std::ios::binary);
  if (!file) {
    throw std::runtime_error("could not open the trained field " + path);
  }
  Header header;
  file.read(reinterpret_cast<char*>(&header), sizeof(header));
  if (!file || std::memcmp(header.magic, kMagic, sizeof(kMagic)) != 0) {
    throw std::runtime_error(path + " is not a trained field");
  }
  if (header.version != kVersion) {
    throw std::runtime_error(
        path + " has the format version " + std::to_string(header.version) +
        ", this program reads version " + std::to_string(kVersion));
  }
  const Header expected = MakeHeader(options, extent);
  if (std::memcmp(&header, &expected, sizeof(header)) != 0) {
    throw std::runtime_error(
        path + " was trained with other field options or on another scene");
  }
  FieldParameters parameters;
  parameters.grid.resize(header.num_grid_values);
  parameters.network.resize(header.num_network_values);
  uint64_t checksum = 0;
  file.read(reinterpret_cast<char*>(parameters.grid.data()),
            parameters.grid.size() * sizeof(float));
  file.read(reinterpret_cast<char*>(parameters.network.data()),
            parameters.network.size() * sizeof(float));
  file.read(reinterpret_cast<char*>(&checksum), sizeof(checksum));
  if (!file || checksum != FileChecksum(header, parameters) ||
      file.peek() != std::ifstream::traits_type::eof()) {
    throw std::runtime_error(path + " is damaged: its checksum does not match");
  }
  return parameters;
}

}  // namespace structnerf
