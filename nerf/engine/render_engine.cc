#include "nerf/engine/render_engine.h"

namespace structnerf {
namespace {

// Points per cell of a rebuilt cache.
constexpr size_t kRebuildPoints = 4;

// Decay that forgets what a cell was.
constexpr float kForget = 0.0f;

}  // namespace

void RenderEngine::RebuildDensityCache() {
  const size_t num_cells = Cache().NumCells();
  for (size_t round = 0; round < kRebuildPoints; ++round) {
    const float decay = round == 0 ? kForget : 1.0f;
    for (size_t done = 0; done < num_cells;
         done += DensityCache::kRefreshCells) {
      RefreshDensityCache(decay);
    }
  }
}

}  // namespace structnerf
