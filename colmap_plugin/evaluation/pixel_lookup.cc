#include "colmap_plugin/evaluation/pixel_lookup.h"

#include "colmap_plugin/colmap_compat.h"

#include <cmath>
#include <limits>

namespace structnerf {

cv::Mat2d GridRays(const colmap::Camera& camera,
                   const cv::Size size,
                   const double offset) {
  const double scale_x = static_cast<double>(camera.width) / size.width;
  const double scale_y = static_cast<double>(camera.height) / size.height;
  const double none = std::numeric_limits<double>::quiet_NaN();
  cv::Mat2d rays(size, cv::Vec2d(none, none));
  for (int row = 0; row < size.height; ++row) {
    for (int col = 0; col < size.width; ++col) {
      Eigen::Vector2d ray;
      if (RayFromImagePoint(
              camera,
              {(col + offset) * scale_x, (row + offset) * scale_y},
              &ray)) {
        rays(row, col) = {ray.x(), ray.y()};
      }
    }
  }
  return rays;
}

cv::Mat1f LookUp(const cv::Mat2d& rays,
                 const colmap::Camera& camera,
                 const cv::Mat1f& depth) {
  const double scale_x = static_cast<double>(depth.cols) / camera.width;
  const double scale_y = static_cast<double>(depth.rows) / camera.height;
  cv::Mat1f found(rays.size(), 0.0f);
  for (int row = 0; row < rays.rows; ++row) {
    for (int col = 0; col < rays.cols; ++col) {
      const cv::Vec2d& ray = rays(row, col);
      Eigen::Vector2d point;
      if (!ImagePointFromRay(camera, {ray[0], ray[1]}, &point)) {
        continue;
      }
      const double x = std::floor(point.x() * scale_x);
      const double y = std::floor(point.y() * scale_y);
      if (x >= 0 && y >= 0 && x < depth.cols && y < depth.rows) {
        const float value = depth(static_cast<int>(y), static_cast<int>(x));
        if (std::isfinite(value) && value > 0) {
          found(row, col) = value;
        }
      }
    }
  }
  return found;
}

}  // namespace structnerf
