#pragma once

#include "nerf/scene.h"

#include <algorithm>
#include <cmath>

namespace structnerf {

// Windows and tolerances in pixels of maps are meant for maps whose longer side
// has so many. Larger ones show the same surfaces with more pixels, and these
// are known no better.
constexpr int kReferenceMapSize = 640;

// Pixels of a view's maps along what is one pixel at the reference size; at
// least 1.
inline double PixelsPerReferencePixel(const PinholeCamera& camera) {
  return std::max(1.0,
                  static_cast<double>(std::max(camera.width, camera.height)) /
                      kReferenceMapSize);
}

// The same as a whole number of pixels, for windows and the distance of pixels
// that are compared.
inline int WholePixelsPerReferencePixel(const PinholeCamera& camera) {
  return static_cast<int>(std::lround(PixelsPerReferencePixel(camera)));
}

}  // namespace structnerf
