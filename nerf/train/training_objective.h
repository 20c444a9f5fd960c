#pragma once

#include "nerf/engine/render_engine.h"
#include "nerf/losses/patch_loss.h"
#include "nerf/losses/sparse_loss.h"
#include "nerf/losses/triple_product.h"
#include "nerf/options.h"
#include "nerf/scene.h"
#include "nerf/scene_frame.h"
#include "nerf/train/matched_depth.h"
#include "nerf/train/ray_drawer.h"
#include "nerf/train/scene_hints.h"
#include "nerf/train/training_views.h"

#include <atomic>
#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

namespace structnerf {

// Patches of rays, and how many of them were seen by a source view.
struct PatchCounts {
  size_t drawn = 0;
  size_t compared = 0;
};

// The StructNeRF objective (paper, eq. 14-15) on a scene: which pixels are
// drawn and what their rays are worth. Every ray carries colour, patch
// consistency (unless that is for keypoints only) and the interpolated prior; a
// part of each tile goes through sparse points, and a part is drawn as groups
// of four pixels of one planar superpixel.
class TrainingObjective {
 public:
  // `train_view_idxs`: views whose rays are drawn; others are held out.
  // `is_guided`: whether priors guide where rays are sampled (RayTile). Priors
  // count where they have a deviation.
  TrainingObjective(const Scene& scene,
                    const SceneFrame& frame,
                    const std::vector<int>& train_view_idxs,
                    const std::vector<std::vector<int>>& sources,
                    const LossOptions& loss_options,
                    const TrainingOptions& training_options,
                    bool is_guided = false);
  ~TrainingObjective();

  const TrainingViews& Views() const { return views_; }

  // Whether a pixel's colour is kept out of training to measure PSNR: one in
  // 256 if no view is held out, else none.
  bool IsHeldOut(int col, int row) const;

  // Tiles in one step: so many that TrainingOptions::rays_per_step fit.
  int NumTiles() const { return num_tiles_; }

  // Rays of one step, which fill its tiles.
  int NumRays() const { return num_tiles_ * kMaxTileRays; }

  // From the next step on, what the field is to learn from matching; null =
  // nothing.
  void SetMatchedDepth(std::shared_ptr<const MatchedDepth> depth) {
    matched_depth_ = std::move(depth);
  }

  // One thread's view of this objective, which must outlive it.
  std::unique_ptr<TileObjective> MakeTileObjective() const;

  // Share of the pixels, by how blank they are, that the far term acts on; 0 if
  // it is off.
  double BlankShare() const;

  // By all tiles since construction.
  PatchCounts CountPatches() const;

 private:
  class Tile;

  // Weights of the depth hints at a step.
  float SparseWeight(int step) const;
  float PriorWeight(int step) const;

  const LossOptions loss_options_;
  const TrainingOptions training_options_;
  const bool holds_out_views_;
  int num_tiles_ = 0;
  const float length_unit_;  // of differences of depth; field units
  const SparseForm sparse_form_;
  const PlanarForm planar_form_;
  TrainingViews views_;
  PatchLoss patch_loss_;
  SceneHints hints_;
  RayDrawer drawer_;
  std::shared_ptr<const MatchedDepth> matched_depth_;  // null = not yet

  // MeasureBlankness of each view; empty if the far term is off.
  std::vector<std::vector<uint8_t>> blankness_;
  mutable std::atomic<size_t> num_drawn_patches_ = 0;
  mutable std::atomic<size_t> num_compared_patches_ = 0;
};

}  // namespace structnerf
