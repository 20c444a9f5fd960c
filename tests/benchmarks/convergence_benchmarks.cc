#include "nerf/engine/tile_sampling.h"
#include "nerf/util/median.h"
#include "tests/benchmarks/engine_benchmarks.h"
#include "tests/benchmarks/sphere_room.h"
#include "tests/benchmarks/trained_room.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include <benchmark/benchmark.h>

namespace structnerf {
namespace {

constexpr int kNumRays = 1024;

// The unit box in centimetres, for a room of six metres.
constexpr double kBoxSize = 600;

// Lengths of the intervals that the wall lies in.
double SpacingAtWall(const RaySamplingParameters& sampling,
                     const DensityCache& cache,
                     const std::vector<RayTile>& tiles) {
  const int n = sampling.num_samples;
  std::vector<float> edges(kMaxTileRays * (n + 1));
  std::vector<double> lengths;
  for (const RayTile& tile : tiles) {
    PerRay<float> jitter;
    jitter.fill(0.5f);
    ChooseIntervals(tile, cache, sampling, jitter, edges.data());
    for (int ray = 0; ray < tile.num_rays; ++ray) {
      const float* const begin = edges.data() + ray * (n + 1);
      const float* const end =
          std::upper_bound(begin + 1, begin + n, SphereRoomDepth(tile, ray));
      lengths.push_back((end[0] - end[-1]) * tile.direction_norm[ray]);
    }
  }
  return Median(&lengths);
}

// Trains from the start, then looks at the rays of the next step.
void Converge(benchmark::State& state,
              const EngineOptions& options,
              const int num_steps) {
  TrainedRoom room(MakeFusedEngine(options), kNumRays);
  for (auto _ : state) {
    room.Train(num_steps);
  }
  const std::vector<RayTile> tiles = room.NextRays();
  std::vector<RayOutputs> outputs;
  room.Engine().Render(tiles, /*with_color=*/false, &outputs);
  std::vector<double> errors;
  for (size_t i = 0; i < tiles.size(); ++i) {
    for (int ray = 0; ray < tiles[i].num_rays; ++ray) {
      errors.push_back(
          std::abs(outputs[i].depth[ray] - SphereRoomDepth(tiles[i], ray)));
    }
  }
  state.counters["depth_error_cm"] = kBoxSize * Median(&errors);

  RaySamplingParameters sampling;
  sampling.num_bins = options.sampling.num_bins;
  sampling.num_samples = options.sampling.num_samples;
  sampling.uniform_share = static_cast<float>(options.sampling.uniform_share);
  state.counters["spacing_cm"] =
      kBoxSize * SpacingAtWall(sampling, room.Engine().Cache(), tiles);

  const WorkCounts before = room.Engine().Work();
  room.Train(1);
  const WorkCounts after = room.Engine().Work();
  const double num_rays = static_cast<double>(after.num_rays - before.num_rays);
  const auto per_ray = [&](const size_t WorkCounts::*count) {
    return static_cast<double>(after.*count - before.*count) / num_rays;
  };
  state.counters["samples/ray"] = per_ray(&WorkCounts::num_samples);
  state.counters["color_samples/ray"] = per_ray(&WorkCounts::num_color_samples);
  state.counters["gradient_samples/ray"] =
      per_ray(&WorkCounts::num_gradient_samples);
}

}  // namespace

void RegisterConvergenceBenchmarks() {
  const std::pair<std::string, int> kRuns[] = {{"medium", 1},
                                               {"medium", 50},
                                               {"medium", 150},
                                               {"medium", 300},
                                               {"medium", 600},
                                               {"medium", 1500},
                                               {"high", 6000}};
  for (const auto& [quality, num_steps] : kRuns) {
    const EngineOptions options = PresetEngineOptions(quality, 2);
    benchmark::RegisterBenchmark(
        ("converge/" + quality + "/steps:" + std::to_string(num_steps)).c_str(),
        [options, num_steps = num_steps](benchmark::State& state) {
          Converge(state, options, num_steps);
        })
        ->Unit(benchmark::kMillisecond)
        ->Iterations(1)
        ->UseRealTime();
  }
}

}  // namespace structnerf
