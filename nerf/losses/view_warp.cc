#include "nerf/losses/view_warp.h"

#include <Eigen/LU>

namespace structnerf {
namespace {

Eigen::Matrix3d CalibrationMatrix(const View& view,
                                  const TrainingViews::Image& image) {
  return view.camera.Resized(image.width, image.height).CalibrationMatrix();
}

}  // namespace

ViewWarp MakeViewWarp(const View& view,
                      const View& source,
                      const TrainingViews::Image& image,
                      const TrainingViews::Image& source_image,
                      const double scale) {
  const Eigen::Matrix3d k = CalibrationMatrix(source, source_image);
  const Eigen::Matrix3d rotation =
      source.cam_from_world_rotation * view.cam_from_world_rotation.transpose();
  // From centres, not translations: the latter are large where the world's
  // origin is far away.
  const Eigen::Vector3d translation =
      source.cam_from_world_rotation *
      (view.ProjectionCenter() - source.ProjectionCenter()) * scale;
  const Eigen::Matrix3d h =
      k * rotation * CalibrationMatrix(view, image).inverse();
  const Eigen::Vector3d b = k * translation;
  ViewWarp warp;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      warp.h[3 * i + j] = static_cast<float>(h(i, j));
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
