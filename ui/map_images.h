#pragma once

#include <QImage>
#include <cstdint>
#include <vector>

namespace structnerf {

// Maps as pictures, in the colours that COLMAP shows them in. All row-major.

// 3 * width * height, interleaved 8-bit RGB.
QImage ImageFromRgb(int width, int height, const std::vector<uint8_t>& rgb);

// z-depth, 0 = no value, which is black.
QImage ImageFromDepth(int width, int height, const std::vector<float>& depth);

// Three planes x, y, z; (0, 0, 0) = no value.
QImage ImageFromNormal(int width, int height, const std::vector<float>& normal);

}  // namespace structnerf
