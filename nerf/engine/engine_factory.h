#pragma once

#include <functional>
#include <memory>

namespace structnerf {

class RenderEngine;
struct EngineOptions;

// Makes the engine of some options. Throws std::invalid_argument if it has none
// for them. To make one of a function, include nerf/engine/render_engine.h.
using EngineFactory =
    std::function<std::unique_ptr<RenderEngine>(const EngineOptions& options)>;

// Knows the hash grid only. nerf/engine/torch_factory.h has the one that knows
// every field.
std::unique_ptr<RenderEngine> MakeGridEngine(const EngineOptions& options);

}  // namespace structnerf
