#pragma once

#include "colmap_plugin/evaluation/depth_evaluation.h"
#include "colmap_plugin/evaluation/plane_deviation.h"
#include "colmap_plugin/evaluation/truth_views.h"
#include "colmap_plugin/stage_progress.h"

#include <string>
#include <vector>

namespace structnerf {

// Plane mean deviation of depth maps, each scaled by its image's median as in
// the paper, and that of the truth in the same regions, which are not all
// plane.
struct PlaneEvaluation {
  PlaneDeviation predicted;
  PlaneDeviation truth;
};

// Of the images in `depth`, whose maps `source` gives; `image_path` has the
// undistorted photographs. `offset`: where in a pixel the maps' values are
// taken, see kPixelCorner. Throws std::runtime_error if a photograph cannot be
// read.
PlaneEvaluation EvaluatePlanes(const DepthEvaluation& depth,
                               const DepthSource& source,
                               double offset,
                               const std::string& image_path,
                               const TruthViews& truth,
                               StageProgress* progress);

}  // namespace structnerf
