#include "tests/support/point_triangulation.h"

#include "tests/support/image_geometry.h"

#include <Eigen/LU>

namespace structnerf::room {

Eigen::Vector3d TriangulatePoint(const SyntheticRoom& room,
                                 const SyntheticPoint& point) {
  constexpr int kNumIterations = 5;
  constexpr double kStep = 1e-6;  // metres
  Eigen::Vector3d xyz = point.xyz;
  for (int iteration = 0; iteration < kNumIterations; ++iteration) {
    Eigen::Matrix3d normal_matrix = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right_side = Eigen::Vector3d::Zero();
    for (const SyntheticTrackElement& element : point.track) {
      const SyntheticImage& image = room.images[element.image_idx];
      Eigen::Matrix<double, 2, 3> jacobian;
      for (int axis = 0; axis < 3; ++axis) {
        const Eigen::Vector3d step = kStep * Eigen::Vector3d::Unit(axis);
        jacobian.col(axis) = (ProjectPoint(room, image, xyz + step) -
                              ProjectPoint(room, image, xyz - step)) /
                             (2 * kStep);
      }
      const Eigen::Vector2d residual =
          ObservationOf(room, element).xy - ProjectPoint(room, image, xyz);
      normal_matrix += jacobian.transpose() * jacobian;
      right_side += jacobian.transpose() * residual;
    }
    xyz += normal_matrix.inverse() * right_side;
  }
  return xyz;
}

double MeanReprojectionError(const SyntheticRoom& room,
                             const SyntheticPoint& point) {
  double sum = 0;
  for (const SyntheticTrackElement& element : point.track) {
    sum += (ObservationOf(room, element).xy -
            ProjectPoint(room, room.images[element.image_idx], point.xyz))
               .norm();
  }
  return sum / point.track.size();
}

}  // namespace structnerf::room
