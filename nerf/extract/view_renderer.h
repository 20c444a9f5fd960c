#pragma once

#include "nerf/engine/render_engine.h"
#include "nerf/progress.h"
#include "nerf/rendered_view.h"
#include "nerf/scene.h"
#include "nerf/scene_frame.h"
#include "nerf/view_selection.h"

namespace structnerf {

// Renders colour, depth and normals through the centre of every pixel of
// `camera`, the view's own or a resized one. The view's photograph is not
// needed. Throws Aborted if told to.
RenderedView RenderPixelCenters(const View& view,
                                const PinholeCamera& camera,
                                const SceneFrame& frame,
                                const Appearance& appearance,
                                RenderEngine* engine,
                                Progress* progress);

}  // namespace structnerf
