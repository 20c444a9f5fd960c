#include "ui/map_images.h"

#include <algorithm>

#include <colmap/mvs/depth_map.h>
#include <colmap/mvs/normal_map.h>
#include <colmap/ui/qt_utils.h>

namespace structnerf {
namespace {

// Depths outside these percentiles get the colour of the nearest one.
constexpr float kMinPercentile = 2;
constexpr float kMaxPercentile = 98;

colmap::mvs::Mat<float> MakeMat(const int width,
                                const int height,
                                const int depth,
                                const std::vector<float>& planes) {
  colmap::mvs::Mat<float> mat(width, height, depth);
  std::copy(planes.begin(), planes.end(), mat.GetPtr());
  return mat;
}

}  // namespace

QImage ImageFromRgb(const int width,
                    const int height,
                    const std::vector<uint8_t>& rgb) {
  return QImage(rgb.data(), width, height, 3 * width, QImage::Format_RGB888)
      .copy();
}

QImage ImageFromDepth(const int width,
                      const int height,
                      const std::vector<float>& depth) {
  const colmap::mvs::DepthMap map(
      MakeMat(width, height, 1, depth), /*depth_min=*/-1, /*depth_max=*/-1);
  return colmap::BitmapToQImageRGB(
      map.ToBitmap(kMinPercentile, kMaxPercentile));
}

QImage ImageFromNormal(const int width,
                       const int height,
                       const std::vector<float>& normal) {
  const colmap::mvs::NormalMap map(MakeMat(width, height, 3, normal));
  return colmap::BitmapToQImageRGB(map.ToBitmap());
}

}  // namespace structnerf
