#pragma once

#include <cstdint>
#include <vector>

namespace structnerf {

// A view as the field renders it while it is still being trained, small, beside
// the photograph. Images are 8-bit interleaved RGB; all row-major.
struct Preview {
  int view_idx = -1;  // into Scene::views
  int width = 0;
  int height = 0;
  std::vector<uint8_t> photograph;  // 3 * width * height
  std::vector<uint8_t> color;       // 3 * width * height
  std::vector<float> depth;         // z, world units, > 0

  // Unit normals in the camera frame, facing the camera; (0, 0, 0) = none.
  // Three planes of width * height.
  std::vector<float> normal;
};

}  // namespace structnerf
