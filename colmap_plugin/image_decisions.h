#pragma once

#include "colmap_plugin/structnerf_options.h"
#include "nerf/analysis/scene_decision.h"

#include <vector>

#include <colmap/scene/reconstruction.h>

namespace structnerf {

// What the images of a model require: undistortion, reduction, masks.
//   max_image_size: of the images that are trained on, see MemoryPlan.
std::vector<SceneDecision> DescribeImages(
    const StructNerfOptions& options,
    const colmap::Reconstruction& reconstruction,
    int max_image_size);

}  // namespace structnerf
