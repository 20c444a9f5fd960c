#pragma once

#include "nerf/losses/patch_loss.h"
#include "nerf/scene.h"

#include <optional>
#include <vector>

namespace structnerf {

// The formulas of PatchLoss once more, in double precision, pixel by pixel and
// without any gradient: what is differentiated numerically.

// Loss of one source; nothing if a tap leaves an image or is masked. `depth` in
// world units.
std::optional<double> ReferencePatchLoss(const Scene& scene,
                                         const PatchLoss::Options& options,
                                         int view_idx,
                                         int source_idx,
                                         int col,
                                         int row,
                                         double depth);

// Mean over the sources with the smallest losses; nothing if none counts.
std::optional<double> ReferencePatchLoss(const Scene& scene,
                                         const PatchLoss::Options& options,
                                         int view_idx,
                                         const std::vector<int>& source_idxs,
                                         int col,
                                         int row,
                                         double depth);

}  // namespace structnerf
