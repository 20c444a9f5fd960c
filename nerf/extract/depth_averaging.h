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

// What the mean of a pixel's depth is made of. All row-major.
struct DepthAgreement {
  // Whether it is of ExtractionOptions::min_num_consistent depths or more, so
  // that the pixel is confirmed: 1 or 0.
  std::vector<uint8_t> is_confirmed;

  // Which other views these pixels' means are of
  // (nerf/extract/consistency_graph.h).
  std::vector<int> graph;

  // Confirmed depths that the mean is of, the pixel's own among them.
  std::vector<uint16_t> num_depths;

  // Their standard deviation, divided by the pixel's depth.
  std::vector<float> spread;
};

// Averages the depth of each pixel of a view with that of other views'
// confirmed pixels that see the same surface: those of `averaging_view_idxs`
// whose own depth where the pixel lands differs by no more than
// `options.averaging_max_depth_error`. Views err independently where
// depth was matched, so their mean is closer to the truth than any of them, and
// the more of them there are, the likelier it is right.
//
// A pixel that is not confirmed itself counts for nothing in its mean: what it
// has only tells which surface is meant.
//
// `confirmed`: of the view and those that are averaged over, depth of confirmed
// pixels only. `depth`: all that the view has, as in DenseMaps; pixels without
// stay without. Throws Aborted if told to.
DepthAgreement AverageDepth(const Scene& scene,
                            const std::vector<DenseMaps>& confirmed,
                            size_t view_idx,
                            const std::vector<int>& averaging_view_idxs,
                            const ExtractionOptions& options,
                            ThreadPool* pool,
                            Progress* progress,
                            std::vector<float>* depth);

}  // namespace structnerf
