#include "tests/support/synthetic_camera.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <Eigen/Geometry>
#include <Eigen/LU>

namespace structnerf {
namespace {

constexpr int kMaxIterations = 50;
constexpr double kStep = 1e-7;
constexpr double kTolerance = 1e-12;  // on the plane z = 1

// Distorted coordinates (before focal length and principal point) of a point
// on the plane z = 1.
Eigen::Vector2d Distort(const SyntheticCamera& camera,
                        const Eigen::Vector2d& uv) {
  const std::vector<double>& p = camera.params;
  const double r2 = uv.squaredNorm();
  if (camera.model == "SIMPLE_RADIAL") {
    return (1 + p[3] * r2) * uv;
  }
  if (camera.model == "OPENCV") {
    const double cross = 2 * uv.x() * uv.y();
    const double radial = 1 + p[4] * r2 + p[5] * r2 * r2;
    return radial * uv +
           Eigen::Vector2d(p[6] * cross + p[7] * (r2 + 2 * uv.x() * uv.x()),
                           p[7] * cross + p[6] * (r2 + 2 * uv.y() * uv.y()));
  }
  if (camera.model == "OPENCV_FISHEYE") {
    const double r = std::sqrt(r2);
    if (r < 1e-12) {
      return uv;
    }
    const double theta = std::atan(r);
    const double t2 = theta * theta;
    const double bent =
        theta * (1 + t2 * (p[4] + t2 * (p[5] + t2 * (p[6] + t2 * p[7]))));
    return (bent / r) * uv;
  }
  return uv;
}

bool HasTwoFocalLengths(const SyntheticCamera& camera) {
  return camera.model != "SIMPLE_RADIAL";
}

Eigen::Vector2d FocalLengths(const SyntheticCamera& camera) {
  return {camera.params[0], camera.params[HasTwoFocalLengths(camera) ? 1 : 0]};
}

Eigen::Vector2d PrincipalPoint(const SyntheticCamera& camera) {
  const int first = HasTwoFocalLengths(camera) ? 2 : 1;
  return {camera.params[first], camera.params[first + 1]};
}

}  // namespace

const std::vector<std::string>& SyntheticCameraModels() {
  static const std::vector<std::string> models = {
      "PINHOLE", "SIMPLE_RADIAL", "OPENCV", "OPENCV_FISHEYE"};
  return models;
}

SyntheticCamera SyntheticCamera::Make(const std::string& model,
                                      const int width,
                                      const int height,
                                      const double zoom) {
  SyntheticCamera camera{model, width, height, {}};
  const double f = 0.82 * zoom * width;
  // Off the middle, as calibration finds it.
  const double cx = 0.5 * width + 0.006 * width;
  const double cy = 0.5 * height - 0.004 * width;
  if (model == "PINHOLE") {
    camera.params = {f, 1.004 * f, cx, cy};
  } else if (model == "SIMPLE_RADIAL") {
    camera.params = {f, cx, cy, -0.09};
  } else if (model == "OPENCV") {
    camera.params = {f, 1.004 * f, cx, cy, -0.14, 0.05, 0.0012, -0.0009};
  } else if (model == "OPENCV_FISHEYE") {
    const double wide = 0.62 * f;
    camera.params = {wide, 1.002 * wide, cx, cy, -0.03, 0.008, -0.002, 0.0003};
  } else {
    throw std::invalid_argument("Unknown camera model " + model +
                                "; use PINHOLE, SIMPLE_RADIAL, OPENCV or "
                                "OPENCV_FISHEYE.");
  }
  return camera;
}

Eigen::Vector2d SyntheticCamera::Project(
    const Eigen::Vector3d& point_in_cam) const {
  return FocalLengths(*this).cwiseProduct(
             Distort(*this, point_in_cam.hnormalized())) +
         PrincipalPoint(*this);
}

Eigen::Vector3d SyntheticCamera::Unproject(
    const Eigen::Vector2d& image_point) const {
  const Eigen::Vector2d target =
      (image_point - PrincipalPoint(*this)).cwiseQuotient(FocalLengths(*this));
  Eigen::Vector2d uv = target;
  if (model == "OPENCV_FISHEYE") {
    // Newton diverges from the distorted point; without the polynomial the
    // inverse is closed.
    const double theta = std::min(target.norm(), 1.5);
    uv *= theta > 1e-12 ? std::tan(theta) / theta : 1.0;
  }
  for (int i = 0; i < kMaxIterations; ++i) {
    const Eigen::Vector2d residual = Distort(*this, uv) - target;
    if (residual.norm() < kTolerance) {
      if (uv.dot(target) < 0) {
        break;  // on the other side, where the distortion has turned around
      }
      return uv.homogeneous();
    }
    const double h = kStep * std::max(1.0, uv.norm());
    const Eigen::Vector2d dx(h, 0);
    const Eigen::Vector2d dy(0, h);
    Eigen::Matrix2d jacobian;
    jacobian << (Distort(*this, uv + dx) - Distort(*this, uv - dx)) / (2 * h),
        (Distort(*this, uv + dy) - Distort(*this, uv - dy)) / (2 * h);
    uv -= jacobian.inverse() * residual;
  }
  throw std::domain_error("The distortion of a " + model +
                          " camera cannot be inverted at image point (" +
                          std::to_string(image_point.x()) + ", " +
                          std::to_string(image_point.y()) + ").");
}

}  // namespace structnerf
