#include "nerf/engine/render_engine.h"

#include <algorithm>

namespace structnerf {
namespace {

// Points per cell of a rebuilt cache.
constexpr size_t kRebuildPoints = 4;

}  // namespace

void RenderEngine::RebuildDensityCache(Progress* progress) {
  MutableCache()->Clear();
  const size_t num_cells = Cache().NumCells();
  for (size_t round = 0; round < kRebuildPoints; ++round) {
    for (size_t done = 0; done < num_cells;
         done += DensityCache::kRefreshCells) {
      PauseOrAbort(progress);
      RefreshDensityCache(/*decay=*/1.0f);
    }
  }
}

void RenderEngine::ApplyLevelWeights(const FieldLayout& layout,
                                     const std::vector<float>& level_weights,
                                     std::vector<float>* grid) {
  for (size_t level = 0; level < level_weights.size(); ++level) {
    const auto begin =
        grid->begin() + static_cast<ptrdiff_t>(
                            layout.levels[level].first_entry * kGridFeatures);
    std::transform(
        begin,
        begin + layout.levels[level].num_entries * kGridFeatures,
        begin,
        [&](const float feature) { return feature * level_weights[level]; });
  }
}

}  // namespace structnerf
