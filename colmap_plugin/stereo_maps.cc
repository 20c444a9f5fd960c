#include "colmap_plugin/stereo_maps.h"

#include <algorithm>

namespace structnerf {

size_t StereoMaps::NumDepths() const {
  return depth.size() - std::count(depth.begin(), depth.end(), 0.0f);
}

void StereoMaps::KeepOnly(const std::vector<uint8_t>& keep) {
  const size_t num_pixels = depth.size();
  for (size_t pixel_idx = 0; pixel_idx < num_pixels; ++pixel_idx) {
    if (keep[pixel_idx] == 0) {
      depth[pixel_idx] = 0;
      for (size_t plane = 0; plane < 3; ++plane) {
        normal[plane * num_pixels + pixel_idx] = 0;
      }
    }
  }
}

}  // namespace structnerf
