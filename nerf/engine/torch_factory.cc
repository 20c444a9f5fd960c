#include "nerf/engine/torch_factory.h"

#include "nerf/engine/engine_factory.h"
#include "nerf/engine/torch_mlp_engine.h"

namespace structnerf {

std::unique_ptr<RenderEngine> MakeAnyEngine(const EngineOptions& options) {
  if (options.field.type == "mlp") {
    return MakeTorchMlpEngine(options, TorchPrecision::kFloat);
  }
  return MakeGridEngine(options);
}

}  // namespace structnerf
