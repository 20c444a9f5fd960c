#pragma once

#include "nerf/losses/view_warp.h"
#include "nerf/options.h"
#include "nerf/progress.h"
#include "nerf/scene.h"
#include "nerf/scene_frame.h"
#include "nerf/train/training_views.h"
#include "nerf/util/thread_pool.h"

#include <cstdint>
#include <vector>

namespace structnerf {

// A plane per pixel of one view: inverse depth (field units) at the pixel's
// centre and its slope per pixel. Inverse depth of a plane is affine in pixel
// coordinates, so moving a plane to a neighbour is one multiply-add per axis.
struct PlaneMaps {
  int width = 0;
  int height = 0;
  std::vector<float> rho;
  std::vector<float> rho_x;
  std::vector<float> rho_y;

  // Matching cost in [0, 2]: one minus the correlation of the patch with those
  // of its best sources; 1 if it has no texture, 2 if no source sees it.
  std::vector<float> cost;

  // How much worse the pixel matches a little in front of and behind its plane:
  // the smallest difference in cost. Near zero (or below) where depth is not
  // seen but only assumed, as on blank surfaces; 0 if no source sees it.
  std::vector<float> distinctness;
};

// Slanted-window stereo (Bleyer et al. 2011) between one view and its sources,
// seeded by the radiance field. Planes spread between neighbouring pixels and
// are perturbed at random; what is kept minimises min(1, cost). The cost is one
// minus the correlation (normalised, bilaterally weighted) of the patch,
// averaged over the best sources. Without any texture the correlation is damped
// to zero, so blank areas keep their seed; masked pixels do, too.
//
// Pixels are worked on in vectors, in two colours of a checkerboard, and the
// random numbers depend on pixel and iteration only: results do not depend on
// the number of threads.
class PatchMatch {
 public:
  // `sources`: as MakeSourceWarps, best first.
  PatchMatch(const Scene& scene,
             const SceneFrame& frame,
             const TrainingViews& views,
             const std::vector<std::vector<int>>& sources,
             const StereoOptions& options);

  // `maps` holds the seed and receives the result. Pixels without a seed, whose
  // inverse depth is not positive, and pixels whose seed no source sees stay as
  // they are, at cost 2. `pool` may be used by nobody else at that time. Throws
  // Aborted if told to abort.
  void Refine(int view_idx,
              ThreadPool* pool,
              Progress* progress,
              PlaneMaps* maps) const;

 private:
  const TrainingViews& views_;
  const StereoOptions options_;
  const SourceWarps source_warps_;
};

}  // namespace structnerf
