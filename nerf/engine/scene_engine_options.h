#pragma once

#include "nerf/engine/render_engine.h"
#include "nerf/options.h"
#include "nerf/scene_frame.h"

#include <cstddef>

namespace structnerf {

// Of the engine that a scene is trained with, and that renders what was
// trained.
EngineOptions MakeEngineOptions(const ReconstructionOptions& options,
                                const SceneFrame& frame,
                                size_t num_views);

}  // namespace structnerf
