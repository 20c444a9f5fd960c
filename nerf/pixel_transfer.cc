#include "nerf/pixel_transfer.h"

#include <Eigen/LU>

namespace structnerf {

PixelTransfer::PixelTransfer(const View& from,
                             const PinholeCamera& from_camera,
                             const View& to,
                             const PinholeCamera& to_camera) {
  const Eigen::Matrix3d to_pixel = to_camera.CalibrationMatrix();
  const Eigen::Matrix3d rotation =
      to.cam_from_world_rotation * from.cam_from_world_rotation.transpose();
  matrix = to_pixel * rotation * from_camera.CalibrationMatrix().inverse();
  // From centres, not translations: the latter are large where the world's
  // origin is far away.
  offset = to_pixel * (to.cam_from_world_rotation *
                       (from.ProjectionCenter() - to.ProjectionCenter()));
}

}  // namespace structnerf
