#include "nerf/train/scene_hints.h"

#include "nerf/train/keypoints.h"

#include <algorithm>
#include <map>

namespace structnerf {
namespace {

// Pixels per cell of interpolated depth.
constexpr int kInterpolationCell = 4;

// A point's error counts at least this share of the mean error.
constexpr float kMinErrorRatio = 0.1f;

}  // namespace

SceneHints::SceneHints(const Scene& scene,
                       const SceneFrame& frame,
                       const std::vector<int>& train_view_idxs,
                       const TrainingViews& views,
                       const LossOptions& options)
    : views_(views), dense_priors_(scene.views.size()) {
  if (options.patch_sampling == "keypoints") {
    CollectKeypoints(train_view_idxs);
  }
  CollectSparseRays(scene, frame, train_view_idxs, options);
  CollectSegments(scene, train_view_idxs);
  CollectDensePriors(scene, frame, train_view_idxs);
}

float SceneHints::InterpolatedDepth(const int view_idx,
                                    const int col,
                                    const int row) const {
  const DepthGrid& grid = interpolated_[view_idx];
  const int grid_col = std::min(col / kInterpolationCell, grid.width - 1);
  const int grid_row = std::min(row / kInterpolationCell, grid.height - 1);
  return grid.depth[grid_row * grid.width + grid_col];
}

PriorDepth SceneHints::DensePrior(const int view_idx,
                                  const int col,
                                  const int row) const {
  const std::vector<PriorDepth>& priors = dense_priors_[view_idx];
  const size_t width = views_.image(view_idx).width;
  return priors.empty() ? PriorDepth() : priors[row * width + col];
}

void SceneHints::CollectKeypoints(const std::vector<int>& train_view_idxs) {
  for (const int view_idx : train_view_idxs) {
    const int width = views_.image(view_idx).width;
    for (const uint32_t pixel : SelectKeypoints(views_, view_idx)) {
      keypoints_.push_back({view_idx,
                            static_cast<int>(pixel % width),
                            static_cast<int>(pixel / width)});
    }
  }
}

void SceneHints::CollectSparseRays(const Scene& scene,
                                   const SceneFrame& frame,
                                   const std::vector<int>& train_view_idxs,
                                   const LossOptions& options) {
  std::vector<std::vector<DepthSample>> samples = CollectDepthSamples(scene);
  for (std::vector<DepthSample>& of_view : samples) {
    // No ray ends nearer, and relative to the depth of a point inside its
    // camera all errors explode.
    of_view.erase(std::remove_if(of_view.begin(),
                                 of_view.end(),
                                 [&](const DepthSample& sample) {
                                   return sample.depth * frame.scale <
                                          frame.near;
                                 }),
                  of_view.end());
  }
  const bool has_deviation =
      SparseFormFromName(options.sparse_form) == SparseForm::kRayTermination;
  for (const int view_idx : train_view_idxs) {
    for (const DepthSample& sample : samples[view_idx]) {
      SparseRay ray;
      ray.view_idx = view_idx;
      ray.x = static_cast<float>(sample.x);
      ray.y = static_cast<float>(sample.y);
      ray.target.depth = static_cast<float>(sample.depth * frame.scale);
      ray.target.deviation = static_cast<float>(options.sparse_deviation) *
                             std::max(sample.error_ratio, kMinErrorRatio) *
                             ray.target.depth;
      // A point with a deviation is distrusted by that.
      ray.target.weight = has_deviation ? 1.0f : sample.weight;
      sparse_rays_.push_back(ray);
    }
  }
  if (options.prior_weight > 0) {
    InterpolateDepths(samples, frame);
  }
}

void SceneHints::InterpolateDepths(
    const std::vector<std::vector<DepthSample>>& samples,
    const SceneFrame& frame) {
  for (size_t v = 0; v < samples.size(); ++v) {
    const TrainingViews::Image& image = views_.image(static_cast<int>(v));
    DepthGrid grid;
    grid.width = (image.width + kInterpolationCell - 1) / kInterpolationCell;
    grid.height = (image.height + kInterpolationCell - 1) / kInterpolationCell;
    grid.depth.resize(static_cast<size_t>(grid.width) * grid.height);
    for (int row = 0; row < grid.height; ++row) {
      for (int col = 0; col < grid.width; ++col) {
        grid.depth[row * grid.width + col] = static_cast<float>(
            frame.scale * InterpolateDepth(samples[v],
                                           (col + 0.5) * kInterpolationCell,
                                           (row + 0.5) * kInterpolationCell));
      }
    }
    interpolated_.push_back(std::move(grid));
  }
}

void SceneHints::CollectSegments(const Scene& scene,
                                 const std::vector<int>& train_view_idxs) {
  double area = 0;
  for (const int view_idx : train_view_idxs) {
    const View& view = scene.views[view_idx];
    std::map<int32_t, std::vector<uint32_t>> pixels;
    for (size_t i = 0; i < view.segments.size(); ++i) {
      const bool is_masked = !view.mask.empty() && view.mask[i] == 0;
      if (view.segments[i] >= 0 && !is_masked) {
        pixels[view.segments[i]].push_back(static_cast<uint32_t>(i));
      }
    }
    for (const auto& [label, segment_pixels] : pixels) {
      segments_.push_back(
          {view_idx, segment_pixels_.size(), segment_pixels.size()});
      segment_pixels_.insert(
          segment_pixels_.end(), segment_pixels.begin(), segment_pixels.end());
      area += static_cast<double>(segment_pixels.size());
      last_segment_area_.push_back(area);
    }
  }
}

void SceneHints::CollectDensePriors(const Scene& scene,
                                    const SceneFrame& frame,
                                    const std::vector<int>& train_view_idxs) {
  const float scale = static_cast<float>(frame.scale);
  for (const int view_idx : train_view_idxs) {
    const View& view = scene.views[view_idx];
    for (size_t i = 0; i < view.prior_deviation.size(); ++i) {
      dense_priors_[view_idx].push_back(
          {view.prior_depth[i] * scale, view.prior_deviation[i] * scale});
    }
  }
}

}  // namespace structnerf
