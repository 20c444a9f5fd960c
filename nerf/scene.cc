#include "nerf/scene.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <Eigen/LU>

namespace structnerf {
namespace {

void Require(const bool condition, const std::string& message) {
  if (!condition) {
    throw std::invalid_argument(message);
  }
}

void CheckView(const View& view) {
  const std::string prefix = "view " + view.name + ": ";
  const PinholeCamera& camera = view.camera;
  Require(camera.width > 0 && camera.height > 0,
          prefix + "the camera has no size");
  Require(std::isfinite(camera.fx) && std::isfinite(camera.fy) &&
              camera.fx > 0 && camera.fy > 0 && std::isfinite(camera.cx) &&
              std::isfinite(camera.cy),
          prefix + "the focal length or principal point is not valid");
  Require(view.cam_from_world_rotation.allFinite() &&
              view.cam_from_world_translation.allFinite(),
          prefix + "the pose is not finite");
  Require(
      (view.cam_from_world_rotation * view.cam_from_world_rotation.transpose() -
       Eigen::Matrix3d::Identity())
                  .cwiseAbs()
                  .maxCoeff() < 1e-6 &&
          view.cam_from_world_rotation.determinant() > 0,
      prefix + "the matrix of the pose is not a rotation");
  const size_t num_pixels =
      static_cast<size_t>(view.image.width) * view.image.height;
  Require(view.image.width > 0 && view.image.height > 0 &&
              view.image.width <= camera.width &&
              view.image.height <= camera.height,
          prefix + "the image is empty or larger than the camera");
  Require(view.image.data.size() == 3 * num_pixels,
          prefix + "the image data do not match its size");
  Require(view.exposure.gain.allFinite() && view.exposure.offset.allFinite() &&
              view.exposure.gain.minCoeff() > 0,
          prefix + "the exposure is not finite or its gain not positive");
  Require(view.mask.empty() || view.mask.size() == num_pixels,
          prefix + "the mask does not match the image's size");
  Require(view.segments.empty() || view.segments.size() == num_pixels,
          prefix + "the segments do not match the image's size");
  Require(std::all_of(view.segments.begin(),
                      view.segments.end(),
                      [&](const int32_t label) {
                        return label >= -1 &&
                               label < static_cast<int64_t>(num_pixels);
                      }),
          prefix +
              "a segment's label is below -1 or not below the number of "
              "pixels");
  const auto are_depths = [&](const std::vector<float>& depths) {
    return (depths.empty() || depths.size() == num_pixels) &&
           std::all_of(depths.begin(), depths.end(), [](const float depth) {
             return std::isfinite(depth) && depth >= 0;
           });
  };
  Require(are_depths(view.prior_depth) && are_depths(view.prior_deviation) &&
              (view.prior_deviation.empty() || !view.prior_depth.empty()),
          prefix +
              "the depth prior does not match the image's size or is not "
              "finite and positive");
  Require(are_depths(view.near_depth) && are_depths(view.far_depth) &&
              view.near_depth.size() == view.far_depth.size(),
          prefix +
              "the bounds of depth do not match the image's size or are "
              "not finite and positive");
}

}  // namespace

PinholeCamera PinholeCamera::Resized(const int new_width,
                                     const int new_height) const {
  const double scale_x = static_cast<double>(new_width) / width;
  const double scale_y = static_cast<double>(new_height) / height;
  return {new_width,
          new_height,
          fx * scale_x,
          fy * scale_y,
          cx * scale_x,
          cy * scale_y};
}

PinholeCamera PinholeCamera::Reduced(const int max_size) const {
  const int longest = std::max(width, height);
  if (longest <= max_size) {
    return *this;
  }
  const double scale = max_size / static_cast<double>(longest);
  return Resized(std::max(1, static_cast<int>(std::lround(scale * width))),
                 std::max(1, static_cast<int>(std::lround(scale * height))));
}

Eigen::Matrix3d PinholeCamera::CalibrationMatrix() const {
  Eigen::Matrix3d k;
  k << fx, 0, cx, 0, fy, cy, 0, 0, 1;
  return k;
}

Eigen::Vector3d View::CamFromWorld(const Eigen::Vector3d& x_in_world) const {
  return cam_from_world_rotation * x_in_world + cam_from_world_translation;
}

Eigen::Vector3d View::WorldFromCam(const Eigen::Vector3d& x_in_cam) const {
  return cam_from_world_rotation.transpose() *
         (x_in_cam - cam_from_world_translation);
}

Eigen::Vector3d View::ProjectionCenter() const {
  return -cam_from_world_rotation.transpose() * cam_from_world_translation;
}

PinholeCamera View::ImageCamera() const {
  return image.data.empty() ? camera
                            : camera.Resized(image.width, image.height);
}

View PoseOf(const View& view) {
  View pose;
  pose.name = view.name;
  pose.camera = view.camera;
  pose.cam_from_world_rotation = view.cam_from_world_rotation;
  pose.cam_from_world_translation = view.cam_from_world_translation;
  pose.exposure = view.exposure;
  return pose;
}

void Scene::Check() const {
  for (const View& view : views) {
    CheckView(view);
  }
  for (size_t i = 0; i < points.size(); ++i) {
    const std::string prefix = "sparse point " + std::to_string(i) + ": ";
    Require(points[i].xyz.allFinite(), prefix + "the position is not finite");
    Require(std::isfinite(points[i].error),
            prefix + "the reprojection error is not finite");
    for (const Observation& observation : points[i].track) {
      Require(observation.view_idx >= 0 &&
                  observation.view_idx < static_cast<int>(views.size()),
              prefix + "its track names a view that does not exist");
      Require(observation.xy.allFinite(),
              prefix + "an observation is not finite");
    }
  }
}

}  // namespace structnerf
