#pragma once

#include "colmap_plugin/image_detail.h"
#include "colmap_plugin/structnerf_options.h"
#include "nerf/analysis/scene_decision.h"

#include <vector>

#include <colmap/scene/reconstruction.h>

namespace structnerf {

// What the images of a model require: undistortion, reduction, masks.
//   detail: what they show, see ChooseImageSize.
//   max_image_size: of the images that are trained on, see MemoryPlan.
std::vector<SceneDecision> DescribeImages(
    const StructNerfOptions& options,
    const colmap::Reconstruction& reconstruction,
    const ImageDetail& detail,
    int max_image_size);

// Lowers the size of the training images to what the photographs show, if the
// options leave that to them, and returns what they show.
ImageDetail ChooseImageSize(const colmap::Reconstruction& reconstruction,
                            StructNerfOptions* options);

}  // namespace structnerf
