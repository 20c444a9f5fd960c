#pragma once

#include "nerf/engine/ray_tile.h"
#include "nerf/losses/view_warp.h"
#include "nerf/scene.h"
#include "nerf/scene_frame.h"
#include "nerf/train/training_views.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace structnerf {

// Most taps per side of a patch.
constexpr int kMaxPatchSide = 7;

// Patch photometric consistency (paper, eq. 5-9). The patch around a pixel, all
// of it at the depth of its centre, is warped into source views, and the loss
// of a source is
//   ssim_share * (1 - SSIM) / 2 + (1 - ssim_share) * mean |difference|
// on grey values in [0, 1]. (The paper prints SSIM where (1 - SSIM) / 2 is
// meant.) A source counts only where every tap falls in front of the camera,
// inside the image and outside its mask, and where no tap of the patch itself
// is masked. At the border of its image the patch stays inside and is off
// centre. Of the sources that count, the num_best with the smallest loss are
// averaged; the others are taken to be occluded.
class PatchLoss {
 public:
  struct Options {
    int radius = 1;    // taps at -radius .. radius, 0 = a single pixel
    int dilation = 2;  // pixels between taps
    float ssim_share = 0.85f;
    int num_best = 4;
  };

  // As MakeSourceWarps.
  PatchLoss(const Scene& scene,
            const SceneFrame& frame,
            const TrainingViews& views,
            const std::vector<std::vector<int>>& sources,
            const Options& options);

  // Rays [0, num_rays) go through pixel (col, row) of view view_idx at z-depth
  // `depth` (field units). Writes each ray's loss, its derivative by depth, and
  // the number of sources that counted, the best or not (all 0 if none did).
  void Evaluate(int num_rays,
                const int* view_idx,
                const int* col,
                const int* row,
                const float* depth,
                float* loss,
                float* d_depth,
                int* num_valid) const;

 private:
  const TrainingViews& views_;
  const Options options_;
  const SourceWarps source_warps_;
};

}  // namespace structnerf
