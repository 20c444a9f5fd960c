#include "tests/benchmarks/trained_room.h"

#include "nerf/analysis/scene_analysis.h"
#include "tests/benchmarks/sphere_room.h"

#include <algorithm>
#include <utility>

namespace structnerf {
namespace {

constexpr float kGridLearningRate = 1e-2f;
constexpr float kNetworkLearningRate = 2e-3f;
constexpr int kCacheInterval = 16;
constexpr float kCacheDecay = 0.8f;

}  // namespace

EngineOptions PresetEngineOptions(const std::string& quality,
                                  const int num_threads) {
  const ReconstructionOptions preset =
      AnalyzeScene(SphereRoomScene(), QualityPreset(quality)).options;
  EngineOptions options;
  options.field = preset.field;
  options.sampling = preset.sampling;
  options.initial_density = 1.6f;
  options.num_threads = num_threads;
  return options;
}

TrainedRoom::TrainedRoom(std::unique_ptr<GridEngine> engine, const int num_rays)
    : engine_(std::move(engine)), objectives_(SphereRoomObjectives(*engine_)) {
  step_.num_tiles = num_rays / kMaxTileRays;
}

double TrainedRoom::Train(const int num_steps) {
  double loss = 0;
  for (int i = 0; i < num_steps; ++i) {
    const LossValues losses = engine_->Accumulate(step_, objectives_);
    loss = losses[0] + losses[1];
    engine_->Update(kGridLearningRate, kNetworkLearningRate);
    if (++step_.step % kCacheInterval == 0) {
      engine_->RefreshDensityCache(kCacheDecay);
    }
  }
  return loss;
}

std::vector<RayTile> TrainedRoom::NextRays() {
  std::vector<RayTile> tiles(step_.num_tiles);
  for (int tile = 0; tile < step_.num_tiles; ++tile) {
    objectives_[0]->DrawRays(step_.step, tile, &tiles[tile]);
  }
  return tiles;
}

size_t TrainedRoom::CountTouchedEntries() {
  engine_->Accumulate(step_, objectives_);
  const std::vector<float> gradient = engine_->Gradients().grid;
  size_t count = 0;
  for (size_t i = 0; i < gradient.size(); i += kGridFeatures) {
    count += std::any_of(gradient.data() + i,
                         gradient.data() + i + kGridFeatures,
                         [](const float g) { return g != 0; });
  }
  Train(1);
  return count;
}

}  // namespace structnerf
