#include "colmap_plugin/evaluation/ply_positions.h"

#include <array>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>

#include <colmap/util/endian.h>

namespace structnerf {
namespace {

const std::map<std::string, size_t> kTypeSizes = {{"char", 1},
                                                  {"uchar", 1},
                                                  {"int8", 1},
                                                  {"uint8", 1},
                                                  {"short", 2},
                                                  {"ushort", 2},
                                                  {"int16", 2},
                                                  {"uint16", 2},
                                                  {"int", 4},
                                                  {"uint", 4},
                                                  {"int32", 4},
                                                  {"uint32", 4},
                                                  {"float", 4},
                                                  {"float32", 4},
                                                  {"double", 8},
                                                  {"float64", 8}};

// A vertex is `num_bytes` long; x, y and z start at these offsets.
struct VertexLayout {
  size_t num_vertices = 0;
  size_t num_bytes = 0;
  std::array<size_t, 3> offsets{};
  std::array<size_t, 3> sizes{};  // 4 or 8; 0 = not there
};

[[noreturn]] void Refuse(const std::string& path, const std::string& reason) {
  throw std::runtime_error("The cloud " + path + " cannot be read: " + reason +
                           ".");
}

void AddProperty(const std::string& path,
                 std::istringstream* line,
                 VertexLayout* layout) {
  std::string type;
  std::string name;
  *line >> type >> name;
  const auto size = kTypeSizes.find(type);
  if (size == kTypeSizes.end()) {
    Refuse(path, "its vertices have a property of type " + type);
  }
  const size_t axis = std::string("xyz").find(name);
  if (name.size() == 1 && axis < 3) {
    const bool is_real = type.find("float") == 0 || type == "double";
    layout->sizes[axis] = is_real ? size->second : 0;
    layout->offsets[axis] = layout->num_bytes;
  }
  layout->num_bytes += size->second;
}

VertexLayout ReadHeader(const std::string& path, std::istream* file) {
  std::string text;
  if (!std::getline(*file, text) || text.substr(0, 3) != "ply") {
    Refuse(path, "it is not a PLY file");
  }
  VertexLayout layout;
  std::string element;
  bool is_binary = false;
  while (std::getline(*file, text) && text.substr(0, 10) != "end_header") {
    std::istringstream line(text);
    std::string keyword;
    line >> keyword;
    if (keyword == "format") {
      is_binary = text.find("binary_little_endian") != std::string::npos;
    } else if (keyword == "element") {
      const bool is_first = element.empty();
      line >> element;
      if (element == "vertex" && is_first) {
        line >> layout.num_vertices;
      }
    } else if (keyword == "property" && element == "vertex") {
      AddProperty(path, &line, &layout);
    }
  }
  if (!is_binary) {
    Refuse(path, "its format is not binary_little_endian");
  }
  if (!*file || layout.sizes[0] == 0 || layout.sizes[1] == 0 ||
      layout.sizes[2] == 0) {
    Refuse(path, "it does not begin with vertices of x, y and z");
  }
  return layout;
}

template <typename T>
T ReadNumber(const char* bytes) {
  T number;
  std::memcpy(&number, bytes, sizeof(number));
  return colmap::LittleEndianToNative(number);
}

}  // namespace

std::vector<Eigen::Vector3d> ReadPlyPositions(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  const VertexLayout layout = ReadHeader(path, &file);
  const size_t num_bytes_left =
      std::filesystem::file_size(path) - static_cast<size_t>(file.tellg());
  if (layout.num_vertices > num_bytes_left / layout.num_bytes) {
    Refuse(path, "it is shorter than it says; was it written to the end?");
  }
  std::vector<Eigen::Vector3d> positions(layout.num_vertices);
  std::vector<char> vertex(layout.num_bytes);
  for (Eigen::Vector3d& position : positions) {
    file.read(vertex.data(), static_cast<std::streamsize>(vertex.size()));
    for (size_t axis = 0; axis < 3; ++axis) {
      const char* const bytes = vertex.data() + layout.offsets[axis];
      position[static_cast<Eigen::Index>(axis)] =
          layout.sizes[axis] == sizeof(double) ? ReadNumber<double>(bytes)
                                               : ReadNumber<float>(bytes);
    }
  }
  return positions;
}

}  // namespace structnerf
