#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace structnerf {

// The part of DenseMaps that COLMAP stores, same layout and conventions.
struct StereoMaps {
  int width = 0;
  int height = 0;
  std::vector<float> depth;   // width * height, 0 = no value
  std::vector<float> normal;  // three planes of width * height

  // Pixels that have a depth.
  size_t NumDepths() const;

  // Takes depth and normal from all pixels whose entry in `keep`, one per
  // pixel, is 0.
  void KeepOnly(const std::vector<uint8_t>& keep);
};

}  // namespace structnerf
