#include "nerf/losses/view_warp.h"

#include "nerf/pixel_transfer.h"

namespace structnerf {

ViewWarp MakeViewWarp(const View& view,
                      const View& source,
                      const TrainingViews::Image& image,
                      const TrainingViews::Image& source_image,
                      const double scale) {
  const PixelTransfer transfer(
      view,
      view.camera.Resized(image.width, image.height),
      source,
      source.camera.Resized(source_image.width, source_image.height));
  const Eigen::Vector3d b = transfer.offset * scale;
  ViewWarp warp;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      warp.h[3 * i + j] = static_cast<float>(transfer.matrix(i, j));
    }
    warp.b[i] = static_cast<float>(b(i));
  }
  warp.width = static_cast<float>(source_image.width);
  warp.height = static_cast<float>(source_image.height);
  warp.first_pixel = static_cast<int32_t>(source_image.first_pixel);
  warp.stride = source_image.width;
  return warp;
}

}  // namespace structnerf
