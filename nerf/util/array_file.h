#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace structnerf {

// An array in a file as COLMAP stores its depth maps (one plane) and normal
// maps (three):
//
//   width&height&planes&   as decimal text without spaces, then at once
//   planes * height * width little-endian 32-bit floats, plane after plane,
//                           row after row
struct FloatArray {
  int width = 0;
  int height = 0;
  std::vector<float> values;  // planes * height * width
};

// Writes beside the name and renames. Throws std::runtime_error, naming the
// file, if the disk is full or cannot be written.
void WriteArrayFile(const std::string& path,
                    int width,
                    int height,
                    const std::vector<float>& values);

// Throws std::runtime_error, naming the file, if it is missing or damaged or
// has another number of planes.
FloatArray ReadArrayFile(const std::string& path, size_t num_planes);

}  // namespace structnerf
