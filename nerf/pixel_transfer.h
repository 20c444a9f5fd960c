#pragma once

#include "nerf/scene.h"

#include <Eigen/Core>

namespace structnerf {

// Map from the image points of one view to those of another. A point (x, y) at
// a depth, in world units along the optical axis, lands at
// depth * matrix * (x, y, 1) + offset, homogeneous, whose third component is
// its depth in the other view.
struct PixelTransfer {
  // `from_camera` and `to_camera` are the views' cameras at the sizes that the
  // image points are meant at.
  PixelTransfer(const View& from,
                const PinholeCamera& from_camera,
                const View& to,
                const PinholeCamera& to_camera);

  // Image point and depth in the other view; false if it is not in front of the
  // camera.
  bool Apply(const double x,
             const double y,
             const double depth,
             Eigen::Vector3d* result) const {
    const Eigen::Vector3d point =
        depth * (matrix * Eigen::Vector3d(x, y, 1)) + offset;
    if (!(point.z() > 0)) {
      return false;
    }
    const double inverse = 1 / point.z();
    *result << point.x() * inverse, point.y() * inverse, point.z();
    return true;
  }

  // The depth alone; not positive if it is not in front of the camera.
  double Depth(const double x, const double y, const double depth) const {
    return depth * matrix.row(2).dot(Eigen::RowVector3d(x, y, 1)) + offset.z();
  }

  Eigen::Matrix3d matrix;
  Eigen::Vector3d offset;
};

}  // namespace structnerf
