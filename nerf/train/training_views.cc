#include "nerf/train/training_views.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include <Eigen/LU>

namespace structnerf {
namespace {

// Rec. 601 luma.
constexpr double kRedWeight = 0.299;
constexpr double kGreenWeight = 0.587;
constexpr double kBlueWeight = 0.114;

}  // namespace

ViewGeometry::ViewGeometry(const View& view,
                           const PinholeCamera& camera,
                           const SceneFrame& frame)
    : center_(frame.FieldFromWorld(view.ProjectionCenter())),
      field_from_pixel_(view.cam_from_world_rotation.transpose() *
                        camera.CalibrationMatrix().inverse()),
      extent_(frame.extent.cast<double>()),
      near_(frame.near),
      bounds_width_(view.image.width),
      bounds_height_(view.image.height),
      bounds_per_x_(static_cast<double>(view.image.width) / camera.width),
      bounds_per_y_(static_cast<double>(view.image.height) / camera.height) {
  for (size_t i = 0; i < view.near_depth.size(); ++i) {
    bounds_.push_back({static_cast<float>(view.near_depth[i] * frame.scale),
                       static_cast<float>(view.far_depth[i] * frame.scale)});
  }
}

void ViewGeometry::SetRay(const double x,
                          const double y,
                          const int ray,
                          RayTile* rays) const {
  const Eigen::Vector3d direction =
      field_from_pixel_ * Eigen::Vector3d(x, y, 1.0);
  double far = std::numeric_limits<double>::max();
  for (int axis = 0; axis < 3; ++axis) {
    const double d = direction[axis];
    if (d > 0) {
      far = std::min(far, (extent_[axis] - center_[axis]) / d);
    } else if (d < 0) {
      far = std::min(far, -center_[axis] / d);
    }
    rays->origin[axis][ray] = static_cast<float>(center_[axis]);
    rays->direction[axis][ray] = static_cast<float>(d);
  }
  rays->direction_norm[ray] = static_cast<float>(direction.norm());
  rays->near[ray] = static_cast<float>(near_);
  // The cameras are inside the box, but one may look out of it from close by.
  rays->far[ray] = static_cast<float>(std::max(far, 2.0 * near_));
  if (!bounds_.empty()) {
    const int col =
        std::min(static_cast<int>(x * bounds_per_x_), bounds_width_ - 1);
    const int row =
        std::min(static_cast<int>(y * bounds_per_y_), bounds_height_ - 1);
    const Bounds& bounds =
        bounds_[static_cast<size_t>(row) * bounds_width_ + col];
    if (bounds.far > bounds.near) {
      rays->near[ray] = bounds.near;
      rays->far[ray] = bounds.far;
    }
  }
}

TrainingViews::TrainingViews(const Scene& scene, const SceneFrame& frame) {
  size_t num_pixels = 0;
  for (const View& view : scene.views) {
    images_.push_back({view.image.width, view.image.height, num_pixels});
    num_pixels += static_cast<size_t>(view.image.width) * view.image.height;
    geometries_.emplace_back(view, view.ImageCamera(), frame);
    exposures_.push_back(view.exposure);
  }
  if (num_pixels > kMaxTrainingPixels) {
    throw std::invalid_argument(
        "the images to train on have 2^30 pixels or more in all; lower "
        "max_image_size");
  }
  colors_.resize(num_pixels);
  grays_.resize(num_pixels + 1);
  for (size_t v = 0; v < scene.views.size(); ++v) {
    const View& view = scene.views[v];
    const size_t first = images_[v].first_pixel;
    const size_t count = view.image.data.size() / 3;
    for (size_t i = 0; i < count; ++i) {
      const uint8_t* const rgb = view.image.data.data() + 3 * i;
      const bool is_masked = !view.mask.empty() && view.mask[i] == 0;
      colors_[first + i] = rgb[0] | (rgb[1] << 8) | (rgb[2] << 16);
      const double gray =
          kRedWeight * rgb[0] + kGreenWeight * rgb[1] + kBlueWeight * rgb[2];
      grays_[first + i] =
          is_masked ? kMaskedGray
                    : static_cast<uint16_t>(gray / 255.0 * kMaxGray + 0.5);
    }
  }
}

Eigen::Vector3f TrainingViews::Color(const int view_idx,
                                     const int col,
                                     const int row) const {
  const Image& image = images_[view_idx];
  const uint32_t color =
      colors_[image.first_pixel + static_cast<size_t>(row) * image.width + col];
  return Eigen::Vector3f(
             color & 0xff, (color >> 8) & 0xff, (color >> 16) & 0xff) /
         255.0f;
}

bool TrainingViews::IsMasked(const int view_idx,
                             const int col,
                             const int row) const {
  const Image& image = images_[view_idx];
  return grays_[image.first_pixel + static_cast<size_t>(row) * image.width +
                col] == kMaskedGray;
}

}  // namespace structnerf
