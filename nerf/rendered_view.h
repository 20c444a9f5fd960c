#pragma once

#include "nerf/scene.h"

#include <vector>

namespace structnerf {

// What a trained field looks like from somewhere, at the size of
// `View::camera`. Unlike those of DenseMaps, the values at (col, row) belong to
// the ray through the pixel's centre (col + 0.5, row + 0.5), as photographs do.
struct RenderedView {
  int width = 0;
  int height = 0;

  // Interleaved RGB in [0, 1], row-major: 3 * width * height. As the mean
  // exposure of the scene shows it.
  std::vector<float> color;

  // z in the camera frame, world units. Row-major.
  std::vector<float> depth;

  // As DenseMaps::normal: three planes of width * height.
  std::vector<float> normal;

  // Makes the colours those of a photograph of this exposure.
  void Expose(const Exposure& exposure);
};

}  // namespace structnerf
