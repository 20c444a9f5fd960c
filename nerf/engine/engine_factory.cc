#include "nerf/engine/engine_factory.h"

#include "nerf/engine/grid_engine.h"

#include <stdexcept>

namespace structnerf {

std::unique_ptr<RenderEngine> MakeGridEngine(const EngineOptions& options) {
  if (options.field.type != "grid") {
    throw std::invalid_argument("the field " + options.field.type +
                                " needs LibTorch, which this program was built "
                                "without");
  }
  return MakeFusedEngine(options);
}

}  // namespace structnerf
