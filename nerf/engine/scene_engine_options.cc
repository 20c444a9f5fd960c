#include "nerf/engine/scene_engine_options.h"

namespace structnerf {
namespace {

// Density at the start: light travels about this share of the scene box.
constexpr float kInitialDensity = 1.6f;

}  // namespace

EngineOptions MakeEngineOptions(const ReconstructionOptions& options,
                                const SceneFrame& frame,
                                const size_t num_views) {
  EngineOptions engine_options;
  engine_options.field = options.field;
  engine_options.sampling = options.sampling;
  engine_options.extent = frame.extent;
  engine_options.initial_density = kInitialDensity;
  engine_options.num_views = static_cast<int>(num_views);
  engine_options.num_threads = options.training.num_threads;
  engine_options.seed = options.training.seed;
  return engine_options;
}

}  // namespace structnerf
