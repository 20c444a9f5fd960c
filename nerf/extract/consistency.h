#pragma once

#include "nerf/dense_maps.h"
#include "nerf/options.h"
#include "nerf/progress.h"
#include "nerf/scene.h"
#include "nerf/util/thread_pool.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace structnerf {

// What other views say about the depth of a view's pixels.
struct ViewConsistency {
  // Whether a pixel is confirmed as well as the options ask for: 1 or 0.
  // Row-major.
  std::vector<uint8_t> is_confirmed;

  // Which views do, of each of these pixels (nerf/extract/consistency_graph.h).
  std::vector<int> graph;

  // The largest angle, in degrees, between the ray of a pixel and that of a
  // view that confirms it; 0 = none does. The depth of a point that is seen
  // under a small angle says little: errors of poses and of matching grow with
  // its inverse, and a wrong depth looks right to both. Row-major.
  std::vector<float> angles;
};

// A source confirms a pixel if its own depth there agrees and the pixel comes
// back (forward-backward reprojection, within the limits of `options`; that in
// pixels is for maps of the reference size, see nerf/extract/map_resolution.h).
// `maps`: of all views; those of the view and of its sources must be present.
// Throws Aborted if told to.
ViewConsistency CheckConsistency(const Scene& scene,
                                 const std::vector<DenseMaps>& maps,
                                 size_t view_idx,
                                 const std::vector<int>& source_view_idxs,
                                 const ExtractionOptions& options,
                                 ThreadPool* pool,
                                 Progress* progress);

// Gives pixels that are not confirmed the depth and the normal of other maps of
// the same view. Those without a depth stay without.
void ReplaceUnconfirmed(const std::vector<uint8_t>& is_confirmed,
                        const DenseMaps& other,
                        DenseMaps* maps);

// The options for a scene that offers less than they ask for: at most all other
// of the `num_sources` views that may confirm others must confirm a pixel, and
// under at most half the median of the angles under which the sparse points are
// seen.
ExtractionOptions FitToScene(const ExtractionOptions& options,
                             const Scene& scene,
                             size_t num_sources);

}  // namespace structnerf
