#include "nerf/train/prior_agreement.h"

#include "nerf/pixel_transfer.h"
#include "nerf/train/training_views.h"

#include <algorithm>
#include <cmath>

namespace structnerf {
namespace {

constexpr float kMinError = 0.05f;
constexpr float kMaxError = 0.5f;
constexpr float kMaxBoundError = 0.15f;
constexpr size_t kNumSmallest = 4;

// A source's prior, as seen from the view that is estimated.
struct Source {
  const View* view;
  PixelTransfer transfer;
};

// Relative difference between a point and the prior of the source it lands in;
// -1 if that says nothing.
float RelativeError(const Source& source,
                    const double x,
                    const double y,
                    const float depth,
                    PriorCounts* counts) {
  Eigen::Vector3d in_source;
  if (!source.transfer.Apply(x, y, depth, &in_source)) {
    ++counts->num_points_behind;
    return -1;
  }
  const RgbImage& image = source.view->image;
  if (!(in_source.x() >= 0 && in_source.y() >= 0 &&
        in_source.x() < image.width && in_source.y() < image.height)) {
    return -1;
  }
  const float prior =
      source.view
          ->prior_depth[static_cast<size_t>(in_source.y()) * image.width +
                        static_cast<size_t>(in_source.x())];
  return prior > 0 ? static_cast<float>(std::abs(prior - in_source.z()) /
                                        in_source.z())
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
    const std::vector<std::vector<int>>& source_view_idxs, Scene* scene) {
  PriorCounts counts;
  std::vector<float> errors;
  for (size_t v = 0; v < scene->views.size(); ++v) {
    View& view = scene->views[v];
    if (view.prior_depth.empty() || !view.prior_deviation.empty()) {
      continue;
    }
    std::vector<Source> sources;
    for (const int source_idx : source_view_idxs[v]) {
      const View& source = scene->views[source_idx];
      if (!source.prior_depth.empty()) {
        sources.push_back(
            {&source,
             PixelTransfer(
                 view, view.ImageCamera(), source, source.ImageCamera())});
      }
    }
    view.prior_deviation.assign(view.prior_depth.size(), 0.0f);
    for (size_t i = 0; i < view.prior_depth.size(); ++i) {
      const float depth = view.prior_depth[i];
      if (depth == 0) {
        continue;
      }
      const double x = i % view.image.width + 0.5;
      const double y = i / view.image.width + 0.5;
      errors.clear();
      for (const Source& source : sources) {
        const float error = RelativeError(source, x, y, depth, &counts);
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
