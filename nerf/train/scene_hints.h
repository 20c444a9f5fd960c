#pragma once

#include "nerf/losses/depth_likelihood.h"
#include "nerf/losses/sparse_loss.h"
#include "nerf/options.h"
#include "nerf/scene.h"
#include "nerf/scene_frame.h"
#include "nerf/train/depth_prior.h"
#include "nerf/train/training_views.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace structnerf {

// What a scene tells about depth besides its photographs, of the views that are
// trained on: places to draw rays through and what is known there. Positions
// are in training images, lengths in field units.
class SceneHints {
 public:
  struct Keypoint {
    int view_idx = -1;
    int col = 0;
    int row = 0;
  };

  // A ray through a sparse point.
  struct SparseRay {
    int view_idx = -1;
    float x = 0;
    float y = 0;
    SparseTarget target;
  };

  // A planar superpixel, as a part of SegmentPixels().
  struct Segment {
    int view_idx = -1;
    size_t first_pixel = 0;
    size_t num_pixels = 0;
  };

  SceneHints(const Scene& scene,
             const SceneFrame& frame,
             const std::vector<int>& train_view_idxs,
             const TrainingViews& views,
             const LossOptions& options);

  // Empty unless options.patch_sampling asks for them.
  const std::vector<Keypoint>& Keypoints() const { return keypoints_; }

  const std::vector<SparseRay>& SparseRays() const { return sparse_rays_; }

  const std::vector<Segment>& Segments() const { return segments_; }

  // row * width + col.
  const std::vector<uint32_t>& SegmentPixels() const { return segment_pixels_; }

  // Number of pixels up to the end of each segment.
  const std::vector<double>& LastSegmentAreas() const {
    return last_segment_area_;
  }

  // Depth interpolated from the sparse points of the view; 0 without any. Only
  // if prior_weight is positive.
  float InterpolatedDepth(int view_idx, int col, int row) const;

  // The view's own depth prior.
  PriorDepth DensePrior(int view_idx, int col, int row) const;

 private:
  void CollectKeypoints(const std::vector<int>& train_view_idxs);
  void CollectSparseRays(const Scene& scene,
                         const SceneFrame& frame,
                         const std::vector<int>& train_view_idxs,
                         const LossOptions& options);
  void InterpolateDepths(const std::vector<std::vector<DepthSample>>& samples,
                         const SceneFrame& frame);
  void CollectSegments(const Scene& scene,
                       const std::vector<int>& train_view_idxs);
  void CollectDensePriors(const Scene& scene,
                          const SceneFrame& frame,
                          const std::vector<int>& train_view_idxs);

  const TrainingViews& views_;
  std::vector<Keypoint> keypoints_;
  std::vector<SparseRay> sparse_rays_;
  std::vector<Segment> segments_;
  std::vector<uint32_t> segment_pixels_;
  std::vector<double> last_segment_area_;

  // Interpolated depth of every kInterpolationCell-th pixel; 0 = none.
  struct DepthGrid {
    int width = 0;
    int height = 0;
    std::vector<float> depth;
  };
  std::vector<DepthGrid> interpolated_;

  // Of each view, per pixel; empty without.
  std::vector<std::vector<PriorDepth>> dense_priors_;
};

}  // namespace structnerf
