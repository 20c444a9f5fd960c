#include "nerf/engine/machine_speed.h"

#include "nerf/engine/grid_engine.h"
#include "nerf/util/cpu_time.h"
#include "nerf/util/random.h"

#include <chrono>
#include <cmath>
#include <memory>
#include <vector>

namespace structnerf {
namespace {

// Small enough to be set up quickly, and for rounds shorter than a time slice.
constexpr int kLog2TableSize = 15;
constexpr int kNumTiles = 256;

// Rounds are repeated for so long.
constexpr double kSeconds = 0.3;

// Seconds of one core of that server for one ray.
constexpr double kReferenceRaySeconds = 1.4e-6;

// Rays from the middle of the scene box in all directions.
std::vector<RayTile> MakeTiles() {
  std::vector<RayTile> tiles(kNumTiles);
  Random random(/*seed=*/0);
  for (RayTile& tile : tiles) {
    tile.num_rays = kMaxTileRays;
    for (int ray = 0; ray < kMaxTileRays; ++ray) {
      float squared_norm = 0;
      for (int axis = 0; axis < 3; ++axis) {
        tile.origin[axis][ray] = 0.5f;
        const float component = random.NextFloat() - 0.5f;
        tile.direction[axis][ray] = component;
        squared_norm += component * component;
      }
      tile.direction_norm[ray] = std::sqrt(squared_norm);
      tile.near[ray] = 0.05f;
      tile.far[ray] = 1.0f;
    }
  }
  return tiles;
}

}  // namespace

double MeasureSlowness(const int num_threads) {
  EngineOptions options;
  options.field.log2_table_size = kLog2TableSize;
  options.num_threads = num_threads;
  const std::unique_ptr<GridEngine> engine = MakeFusedEngine(options);
  const std::vector<RayTile> tiles = MakeTiles();
  std::vector<RayOutputs> outputs;
  engine->Render(tiles, /*with_color=*/false, &outputs);  // warms up
  const auto begin = std::chrono::steady_clock::now();
  const double cpu_begin = ProcessCpuSeconds();
  int num_rounds = 0;
  double seconds = 0;
  while (seconds < kSeconds) {
    engine->Render(tiles, /*with_color=*/false, &outputs);
    ++num_rounds;
    seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin)
            .count();
  }
  const double cpu_seconds = ProcessCpuSeconds() - cpu_begin;
  const double num_rays =
      static_cast<double>(num_rounds) * kNumTiles * kMaxTileRays;
  const double crowding = seconds * engine->NumThreads() / cpu_seconds;
  return crowding * std::sqrt(cpu_seconds / (num_rays * kReferenceRaySeconds));
}

}  // namespace structnerf
