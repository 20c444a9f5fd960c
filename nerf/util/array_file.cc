#include "nerf/util/array_file.h"

#include "nerf/util/whole_file.h"

#include <filesystem>
#include <fstream>
#include <stdexcept>

namespace structnerf {
namespace {

static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__,
              "arrays are written as they are in memory");

// Of arrays that are read; what is larger is no map of ours.
constexpr int kMaxSide = 1 << 16;

}  // namespace

void WriteArrayFile(const std::string& path,
                    const int width,
                    const int height,
                    const std::vector<float>& values) {
  const size_t num_planes =
      values.size() / (static_cast<size_t>(width) * height);
  WriteWholeFile(path, [&](std::ostream* stream) {
    *stream << width << "&" << height << "&" << num_planes << "&";
    stream->write(reinterpret_cast<const char*>(values.data()),
                  static_cast<std::streamsize>(values.size() * sizeof(float)));
  });
}

FloatArray ReadArrayFile(const std::string& path, const size_t num_planes) {
  std::ifstream file(path, std::ios::binary);
  FloatArray array;
  size_t num_found_planes = 0;
  char separators[3] = {};
  file >> array.width >> separators[0] >> array.height >> separators[1] >>
      num_found_planes >> separators[2];
  const bool has_header = file && std::string(separators, 3) == "&&&" &&
                          array.width > 0 && array.height > 0 &&
                          array.width <= kMaxSide && array.height <= kMaxSide &&
                          num_found_planes == num_planes;
  const size_t num_values = num_planes * array.width * array.height;
  const size_t num_bytes = num_values * sizeof(float);
  if (has_header && std::filesystem::file_size(path) ==
                        static_cast<size_t>(file.tellg()) + num_bytes) {
    array.values.resize(num_values);
    file.read(reinterpret_cast<char*>(array.values.data()),
              static_cast<std::streamsize>(num_bytes));
  }
  if (!file || array.values.empty()) {
    throw std::runtime_error("The map " + path +
                             " is missing or damaged; run again.");
  }
  return array;
}

}  // namespace structnerf
