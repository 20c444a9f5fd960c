#pragma once

#include "nerf/engine/render_engine.h"

#include <memory>

namespace structnerf {

// Knows every field: the hash grid, on the CPU without LibTorch, and NeRF's
// networks with it. An EngineFactory.
std::unique_ptr<RenderEngine> MakeAnyEngine(const EngineOptions& options);

}  // namespace structnerf
