#include "nerf/engine/grid_engine.h"

#include "nerf/kernels/adam.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace structnerf {
namespace {

// Points per cell of a rebuilt cache.
constexpr size_t kRebuildPoints = 4;

}  // namespace

void GridEngine::RebuildDensityCache(Progress* progress) {
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

DensityCache GridEngine::MakeCache(const EngineOptions& options) {
  return DensityCache(options.sampling.cache_resolution,
                      options.extent,
                      options.initial_density);
}

RaySamplingParameters GridEngine::MakeSamplingParameters(
    const SamplingOptions& options) {
  RaySamplingParameters parameters;
  parameters.num_bins = options.num_bins;
  parameters.num_samples = options.num_samples;
  parameters.uniform_share = static_cast<float>(options.uniform_share);
  return parameters;
}

float GridEngine::BiasCorrectedRate(const float learning_rate,
                                    const int num_updates) {
  const AdamStep step;
  const double correction1 = 1 - std::pow(step.beta1, num_updates);
  const double correction2 = 1 - std::pow(step.beta2, num_updates);
  return static_cast<float>(learning_rate * std::sqrt(correction2) /
                            correction1);
}

void GridEngine::ApplyLevelWeights(const FieldLayout& layout,
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

void GridEngine::SaveHead(const FieldLayout& layout,
                          const std::vector<float>& level_weights,
                          const int num_updates,
                          StateWriter* writer) {
  writer->WriteValue(static_cast<uint64_t>(layout.num_grid_entries));
  writer->WriteValue(static_cast<uint64_t>(layout.num_network_parameters));
  writer->WriteArray(level_weights);
  writer->WriteValue(num_updates);
}

void GridEngine::LoadHead(const FieldLayout& layout,
                          StateReader* reader,
                          std::vector<float>* level_weights,
                          int* num_updates) {
  const auto num_grid_entries = reader->ReadValue<uint64_t>();
  const auto num_network_parameters = reader->ReadValue<uint64_t>();
  *level_weights = reader->ReadArray<std::vector<float>>();
  *num_updates = reader->ReadValue<int>();
  if (num_grid_entries != layout.num_grid_entries ||
      num_network_parameters != layout.num_network_parameters ||
      (!level_weights->empty() &&
       level_weights->size() != layout.levels.size())) {
    throw std::runtime_error("the state is that of a field of another size");
  }
}

}  // namespace structnerf
