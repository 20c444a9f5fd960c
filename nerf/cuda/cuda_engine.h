#pragma once

#include "nerf/engine/render_engine.h"

#include <functional>
#include <memory>
#include <string>

namespace structnerf {

// The hash grid on an NVIDIA graphics card. Throws std::runtime_error, saying
// why, if there is none that can be used, and std::invalid_argument for other
// fields. `warn`: see DeviceEngine.
std::unique_ptr<RenderEngine> MakeCudaEngine(
    const EngineOptions& options, std::function<void(const std::string&)> warn);

}  // namespace structnerf
