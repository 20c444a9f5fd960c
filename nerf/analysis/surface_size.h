#pragma once

#include "nerf/scene.h"
#include "nerf/scene_frame.h"

namespace structnerf {

// Cells that surfaces pass through in a grid with so many cells along the
// longest side of the scene box. Surfaces are taken to lie where the sparse
// points of each view, interpolated over its image, say.
double CountSurfaceCells(const Scene& scene,
                         const SceneFrame& frame,
                         int resolution);

}  // namespace structnerf
