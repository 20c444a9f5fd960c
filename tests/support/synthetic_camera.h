#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

namespace structnerf {

// A camera of one of COLMAP's models. Parameters are in COLMAP's order:
//   PINHOLE         fx, fy, cx, cy
//   SIMPLE_RADIAL   f, cx, cy, k
//   OPENCV          fx, fy, cx, cy, k1, k2, p1, p2
//   OPENCV_FISHEYE  fx, fy, cx, cy, k1, k2, k3, k4
// Image coordinates in pixels; the first pixel's centre is (0.5, 0.5). Camera
// axes: x right, y down, z forward. The inverse mapping is our own, so tests
// of undistortion compare with something that is not COLMAP's.
struct SyntheticCamera {
  std::string model;
  int width = 0;
  int height = 0;
  std::vector<double> params;

  // A camera with the focal length (and distortion) of a common phone or, for
  // the fisheye model, action camera; `zoom` multiplies the focal length.
  // Throws std::invalid_argument for a model that is not listed above.
  static SyntheticCamera Make(const std::string& model,
                              int width,
                              int height,
                              double zoom);

  // Image point of a point in the camera frame with positive z.
  Eigen::Vector2d Project(const Eigen::Vector3d& point_in_cam) const;

  // Point on the plane z = 1 of the camera frame seen at an image point. Throws
  // std::domain_error if the distortion cannot be inverted there.
  Eigen::Vector3d Unproject(const Eigen::Vector2d& image_point) const;
};

// Models that SyntheticCamera knows.
const std::vector<std::string>& SyntheticCameraModels();

}  // namespace structnerf
