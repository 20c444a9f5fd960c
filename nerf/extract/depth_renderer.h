#pragma once

#include "nerf/dense_maps.h"
#include "nerf/engine/render_engine.h"
#include "nerf/progress.h"
#include "nerf/scene.h"
#include "nerf/scene_frame.h"

namespace structnerf {

// Renders depth and its relative standard deviation for every pixel of a view
// (normals stay empty). Every second pixel in both directions is rendered; the
// others are interpolated in inverse depth, which is exact on planes, where
// their neighbours agree, and rendered where they do not.
DenseMaps RenderDepth(const View& view,
                      const SceneFrame& frame,
                      RenderEngine* engine,
                      Progress* progress);

}  // namespace structnerf
