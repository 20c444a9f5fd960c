#pragma once

#include "nerf/engine/ray_tile.h"
#include "nerf/losses/planar_loss.h"
#include "nerf/losses/sparse_loss.h"
#include "nerf/losses/triple_product.h"
#include "nerf/options.h"
#include "nerf/scene.h"
#include "nerf/train/scene_hints.h"
#include "nerf/train/training_views.h"
#include "nerf/util/random.h"

#include <cstddef>
#include <vector>

namespace structnerf {

// At most so many groups of four planar pixels are in a tile, and either none
// or so many rays through sparse points.
constexpr int kNumPlanarGroups = 2;
constexpr int kNumSparseRays = 4;

// The rays of a tile and why they were drawn, in this order: planar groups,
// rays through sparse points, through keypoints, and through any pixels.
struct DrawnRays {
  RayTile* tile = nullptr;

  // The pixel of the training image that a ray goes through.
  PerRay<int> view_idx;
  PerRay<int> col;
  PerRay<int> row;

  // Group i is that of rays 4 i to 4 i + 3. What makes it a group is only known
  // for PlanarForm::kInverseDepth.
  int num_planar_groups = 0;
  PlanarGroup planar_groups[kNumPlanarGroups];

  // Where each of the other parts begins; the last ends with the tile.
  int first_sparse_ray = 0;
  int first_keypoint_ray = 0;
  int first_random_ray = 0;

  // What is known about rays through sparse points, only set for these.
  PerRay<SparseTarget> sparse_target;

  bool IsSparse(const int ray) const {
    return ray >= first_sparse_ray && ray < first_keypoint_ray;
  }
};

// Draws the rays that are trained on. A constant may serve many threads.
class RayDrawer {
 public:
  // `train_view_idxs`: views whose rays are drawn. `is_guided`: whether priors
  // guide where rays are sampled (RayTile). `views` and `hints` must outlive
  // the drawer. Throws std::invalid_argument if masks leave no pixel.
  RayDrawer(const Scene& scene,
            const std::vector<int>& train_view_idxs,
            const TrainingViews& views,
            const SceneHints& hints,
            const LossOptions& loss_options,
            int seed,
            bool is_guided);

  // Fills a tile with kMaxTileRays rays, which depend on seed, step and tile
  // only. `with_sparse`: whether some go through sparse points, which the scene
  // must then have. `drawn` points to `rays` afterwards.
  void Draw(int step,
            int tile,
            bool with_sparse,
            RayTile* rays,
            DrawnRays* drawn) const;

 private:
  void CollectPixels(const Scene& scene,
                     const std::vector<int>& train_view_idxs);

  void DrawPlanarGroup(Random* random, DrawnRays* drawn) const;
  void DrawSparseRay(Random* random, DrawnRays* drawn) const;
  void DrawKeypointRay(Random* random, DrawnRays* drawn) const;
  void DrawRandomRay(Random* random, DrawnRays* drawn) const;

  // Every ray goes through a pixel's centre, except those through sparse
  // points.
  void AddRay(int view_idx, double x, double y, DrawnRays* drawn) const;

  const TrainingViews& views_;
  const SceneHints& hints_;
  const PlanarForm planar_form_;
  const bool has_planar_groups_;
  const bool has_keypoint_rays_;
  const int seed_;
  const bool is_guided_;

  // A row of a view that is trained on.
  struct PixelRow {
    int view_idx = -1;
    int row = 0;
    size_t last_pixel = 0;  // cumulative number of unmasked pixels
  };
  std::vector<PixelRow> pixel_rows_;
};

}  // namespace structnerf
