#include "nerf/train/prior_agreement.h"

#include "nerf/train/training_views.h"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

namespace structnerf {
namespace {

constexpr float kMinError = 0.05f;
constexpr float kMaxError = 0.5f;
constexpr float kMaxBoundError = 0.15f;
constexpr size_t kNumSmallest = 4;

// Image point (x, y, 1) of a view at depth d lands in a source at
// d * from_pixel (x, y, 1) + offset, homogeneous pixels times depth.
struct SourceMap {
  SourceMap(const View& view, const View& source_view) : source(source_view) {
    const Eigen::Matrix3d rotation = source.cam_from_world_rotation *
                                     view.cam_from_world_rotation.transpose();
    const Eigen::Matrix3d k = source.ImageCamera().CalibrationMatrix();
    from_pixel =
        k * rotation * view.ImageCamera().CalibrationMatrix().inverse();
    offset = k * (source.cam_from_world_translation -
                  rotation * view.cam_from_world_translation);
  }

  const View& source;
  Eigen::Matrix3d from_pixel;
  Eigen::Vector3d offset;
};

// Relative difference between a point and the prior of the source it lands in;
// -1 if that says nothing.
float RelativeError(const SourceMap& map,
                    const Eigen::Vector3d& pixel,
                    const float depth,
                    PriorCounts* counts) {
  const Eigen::Vector3d point = depth * (map.from_pixel * pixel) + map.offset;
  if (!(point.z() > 0)) {
    ++counts->num_points_behind;
    return -1;
  }
  const RgbImage& image = map.source.image;
  const double x = point.x() / point.z();
  const double y = point.y() / point.z();
  if (!(x >= 0 && y >= 0 && x < image.width && y < image.height)) {
    return -1;
  }
  const float prior =
      map.source.prior_depth[static_cast<size_t>(y) * image.width +
                             static_cast<size_t>(x)];
  return prior > 0 ? static_cast<float>(std::abs(prior - point.z()) / point.z())
                   : -1.0f;
}

// Mean of the smallest ones; kMaxError if there is none.
float MeanOfSmallest(std::vector<float>* errors) {
  if (errors->empty()) {
    return kMaxError;
  }
  std::sort(errors->begin(), errors->end());
  const size_t count = std::min(errors->size(), kNumSmallest);
  float sum = 0;
  for (size_t i = 0; i < count; ++i) {
    sum += (*errors)[i];
  }
  return std::min(std::max(sum / static_cast<float>(count), kMinError),
                  kMaxError);
}

}  // namespace

PriorCounts EstimatePriorDeviations(
    const std::vector<std::vector<int>>& sources, Scene* scene) {
  PriorCounts counts;
  std::vector<float> errors;
  for (size_t v = 0; v < scene->views.size(); ++v) {
    View& view = scene->views[v];
    if (view.prior_depth.empty() || !view.prior_deviation.empty()) {
      continue;
    }
    std::vector<SourceMap> maps;
    for (const int source : sources[v]) {
      if (!scene->views[source].prior_depth.empty()) {
        maps.emplace_back(view, scene->views[source]);
      }
    }
    view.prior_deviation.assign(view.prior_depth.size(), 0.0f);
    for (size_t i = 0; i < view.prior_depth.size(); ++i) {
      const float depth = view.prior_depth[i];
      if (depth == 0) {
        continue;
      }
      const Eigen::Vector3d pixel(
          i % view.image.width + 0.5, i / view.image.width + 0.5, 1.0);
      errors.clear();
      for (const SourceMap& map : maps) {
        const float error = RelativeError(map, pixel, depth, &counts);
        if (error >= 0) {
          errors.push_back(error);
        }
      }
      counts.num_unconfirmed += errors.empty();
      view.prior_deviation[i] = depth * MeanOfSmallest(&errors);
    }
  }
  return counts;
}

PriorCounts BoundRaysByPriors(const SceneFrame& frame, Scene* scene) {
  PriorCounts counts;
  for (View& view : scene->views) {
    if (view.prior_depth.empty()) {
      continue;
    }
    const ViewGeometry geometry(view, view.ImageCamera(), frame);
    view.near_depth.assign(view.prior_depth.size(), 0.0f);
    view.far_depth.assign(view.prior_depth.size(), 0.0f);
    for (size_t i = 0; i < view.prior_depth.size(); ++i) {
      const float depth = view.prior_depth[i];
      if (depth == 0) {
        continue;
      }
      RayTile ray;
      geometry.SetRay(i % view.image.width + 0.5,
                      i / view.image.width + 0.5,
                      /*ray=*/0,
                      &ray);
      const float world_from_field = static_cast<float>(1.0 / frame.scale);
      const float reach =
          std::min(std::max(view.prior_deviation[i], kMinError * depth),
                   kMaxBoundError * depth);
      const float near =
          std::max(depth - reach, world_from_field * ray.near[0]);
      const float far = std::min(depth + reach, world_from_field * ray.far[0]);
      if (near < far) {
        view.near_depth[i] = near;
        view.far_depth[i] = far;
      } else {
        ++counts.num_inverted_ranges;
      }
    }
  }
  return counts;
}

}  // namespace structnerf
