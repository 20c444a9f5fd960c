#pragma once

#include <cstddef>
#include <vector>

namespace structnerf {

// Depth and normals of one view, at the size of `View::camera`.
//
// Pixel convention: the value at (col, row) belongs to the ray through the
// image point (col, row), not through the pixel's centre. COLMAP's PatchMatch
// and fusion back-project pixels this way, so fused points are exact.
struct DenseMaps {
  int width = 0;
  int height = 0;

  // z in the camera frame, world units; 0 = no value. Row-major.
  std::vector<float> depth;

  // Unit normals in the camera frame, facing the camera (dot(normal, ray) < 0);
  // (0, 0, 0) where there is no depth. Three planes x, y, z of width * height.
  std::vector<float> normal;

  // Standard deviation of the ray's termination depth divided by its depth;
  // small = certain. Row-major.
  std::vector<float> relative_std;

  // How much worse the pixel matches a little nearer and farther away, in cost
  // (PlaneMaps in nerf/stereo/patch_match.h); 0 where its depth was not
  // matched. Row-major; empty without matching.
  std::vector<float> distinctness;
};

// Takes depth and normal from all pixels but those that `keep(pixel)` says.
template <typename Predicate>
void KeepOnly(const Predicate& keep, DenseMaps* maps) {
  const size_t num_pixels = maps->depth.size();
  for (size_t i = 0; i < num_pixels; ++i) {
    if (!keep(i)) {
      maps->depth[i] = 0;
      for (size_t axis = 0; axis < 3; ++axis) {
        maps->normal[axis * num_pixels + i] = 0;
      }
    }
  }
}

}  // namespace structnerf
