#pragma once

#include "nerf/scene.h"
#include "nerf/scene_frame.h"

#include <cstddef>
#include <vector>

namespace structnerf {

// What was left out when priors of views were compared.
struct PriorCounts {
  size_t num_points_behind = 0;  // behind the other view's camera
  size_t num_unconfirmed = 0;  // pixels that no other view says anything about
  size_t num_inverted_ranges =
      0;  // rays whose range would end before it begins
};

// Fills in the deviation of priors that come without: a pixel's depth times its
// error map, the mean of the (up to) four smallest relative differences between
// its depth in a source view and that view's own prior there (Wei et al. 2021,
// "NerfingMVS", section 3.3, which asks all other views). Differences count
// from 5 to 50 %; pixels that no source confirms get the largest.
//   source_view_idxs: views to ask, of each view.
PriorCounts EstimatePriorDeviations(
    const std::vector<std::vector<int>>& source_view_idxs, Scene* scene);

// Limits the rays of every pixel with a prior to depth +- deviation, the latter
// clamped to 5 to 15 % of the depth (NerfingMVS, eq. 6-7), as View::near_depth
// and View::far_depth. Rays that would so begin beyond their end, as where the
// prior lies behind the scene box or nearer than anything may be, stay as they
// are and are counted.
PriorCounts BoundRaysByPriors(const SceneFrame& frame, Scene* scene);

}  // namespace structnerf
