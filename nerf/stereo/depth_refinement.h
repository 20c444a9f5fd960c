#pragma once

#include "nerf/dense_maps.h"
#include "nerf/progress.h"
#include "nerf/scene.h"
#include "nerf/scene_frame.h"
#include "nerf/stereo/patch_match.h"
#include "nerf/util/thread_pool.h"

namespace structnerf {

// The planes of depth and normals in `maps`, for the pixels of the view's
// training image; inverse depth 0 where there is no depth.
PlaneMaps PlanesOfMaps(const View& view,
                       const SceneFrame& frame,
                       const TrainingViews::Image& image,
                       ThreadPool* pool,
                       const DenseMaps& maps);

// Matches a view's patches with its sources, starting from the rendered depth
// and normals in `maps`, and puts the planes found there, with their
// distinctness. Pixels that do not match at all, and those without a depth,
// stay as they are. Throws Aborted if told to abort.
void RefineDepth(const View& view,
                 int view_idx,
                 const SceneFrame& frame,
                 const TrainingViews::Image& image,
                 const PatchMatch& patch_match,
                 ThreadPool* pool,
                 Progress* progress,
                 DenseMaps* maps);

}  // namespace structnerf
