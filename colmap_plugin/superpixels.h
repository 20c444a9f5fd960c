#pragma once

#include "nerf/scene.h"

#include <cstdint>
#include <vector>

namespace structnerf {

// Splits an image into superpixels of similar colour (Felzenszwalb and
// Huttenlocher 2004), as the paper does to find planar regions. Returns one
// label per pixel, row-major; -1 for superpixels of fewer than `min_area`
// pixels, the others are numbered from 0.
std::vector<int32_t> FindLargeSuperpixels(const RgbImage& image, int min_area);

}  // namespace structnerf
