#pragma once

#include "nerf/losses/view_warp.h"

namespace structnerf {

// Where the centre of a pixel at inverse depth rho (field units) falls in a
// source view; false if outside of its image or behind it. `depth_ratio` is the
// depth there over that in the view.
inline bool ProjectPixel(const ViewWarp& warp,
                         const int col,
                         const int row,
                         const float rho,
                         int* source_col,
                         int* source_row,
                         float* depth_ratio) {
  const float x = static_cast<float>(col) + 0.5f;
  const float y = static_cast<float>(row) + 0.5f;
  float p[3];
  for (int i = 0; i < 3; ++i) {
    p[i] = warp.h[3 * i] * x + warp.h[3 * i + 1] * y + warp.h[3 * i + 2] +
           warp.b[i] * rho;
  }
  if (!(p[2] > kMinDepthRatio)) {
    return false;
  }
  const float u = p[0] / p[2];
  const float v = p[1] / p[2];
  if (!(u >= 0 && v >= 0 && u < warp.width && v < warp.height)) {
    return false;
  }
  *source_col = static_cast<int>(u);
  *source_row = static_cast<int>(v);
  *depth_ratio = p[2];
  return true;
}

}  // namespace structnerf
