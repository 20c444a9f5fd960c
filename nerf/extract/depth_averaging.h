#pragma once

#include "nerf/dense_maps.h"
#include "nerf/options.h"
#include "nerf/progress.h"
#include "nerf/scene.h"
#include "nerf/util/thread_pool.h"

#include <cstddef>
#include <vector>

namespace structnerf {

// Averages the depth of each pixel of a view with that of other views'
// confirmed pixels that see the same surface: those of `averaging_view_idxs`
// whose own depth where the pixel lands differs by no more than
// `options.averaging_max_depth_error`. Views err independently where
// depth was matched, so their mean is closer to the truth than any of them.
//
// A pixel that is not confirmed itself counts for nothing in its mean: what it
// has only tells which surface is meant.
//
// `confirmed`: of the view and those that are averaged over, depth of confirmed
// pixels only. `depth`: all that the view has, as in DenseMaps; pixels without
// stay without. Throws Aborted if told to.
void AverageDepth(const Scene& scene,
                  const std::vector<DenseMaps>& confirmed,
                  size_t view_idx,
                  const std::vector<int>& averaging_view_idxs,
                  const ExtractionOptions& options,
                  ThreadPool* pool,
                  Progress* progress,
                  std::vector<float>* depth);

}  // namespace structnerf
