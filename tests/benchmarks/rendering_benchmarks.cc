#include "nerf/progress.h"
#include "nerf/util/cpu_time.h"
#include "tests/benchmarks/engine_benchmarks.h"
#include "tests/benchmarks/sphere_room.h"
#include "tests/benchmarks/trained_room.h"

#include <cmath>

#include <benchmark/benchmark.h>

namespace structnerf {
namespace {

constexpr int kWarmUpSteps = 150;
constexpr int kNumRays = 1024;
constexpr int kWidth = 320;
constexpr int kHeight = 240;

void Render(benchmark::State& state,
            const EngineOptions& options,
            const bool is_view,
            const bool with_color) {
  TrainedRoom room(MakeFusedEngine(options), kNumRays);
  room.Train(kWarmUpSteps);
  std::vector<RayTile> tiles = room.NextRays();
  if (is_view) {
    Progress silent;
    room.Engine().RebuildDensityCache(&silent);
    tiles = SphereRoomView(kWidth, kHeight);
  }
  size_t num_rays = 0;
  for (const RayTile& tile : tiles) {
    num_rays += tile.num_rays;
  }
  std::vector<RayOutputs> outputs;
  const double cpu_before = ProcessCpuSeconds();
  for (auto _ : state) {
    room.Engine().Render(tiles, with_color, &outputs);
  }
  const double cpu_seconds = ProcessCpuSeconds() - cpu_before;
  if (!std::isfinite(outputs[0].depth[0])) {
    state.SkipWithError("the depth is not finite");
    return;
  }
  const double total_rays =
      static_cast<double>(num_rays) * static_cast<double>(state.iterations());
  const double cpu_rate = options.num_threads * total_rays / cpu_seconds;
  const double num_samples = options.sampling.num_samples;
  state.counters["samples/s"] =
      benchmark::Counter(num_samples * total_rays, benchmark::Counter::kIsRate);
  state.counters["rays/s"] =
      benchmark::Counter(total_rays, benchmark::Counter::kIsRate);
  state.counters["cpu_samples/s"] = num_samples * cpu_rate;
  if (is_view) {
    state.counters["cpu_megapixels/s"] = 1e-6 * cpu_rate;
  }
}

void Register(const std::string& name,
              const EngineOptions& options,
              const bool is_view,
              const bool with_color) {
  benchmark::RegisterBenchmark(name.c_str(),
                               [=](benchmark::State& state) {
                                 Render(state, options, is_view, with_color);
                               })
      ->Unit(benchmark::kMillisecond)
      ->MeasureProcessCPUTime()
      ->UseRealTime();
}

}  // namespace

void RegisterRenderingBenchmarks() {
  for (const int num_threads : {1, 2}) {
    const std::string threads = "/threads:" + std::to_string(num_threads);
    for (const std::string quality : {"low", "medium", "high"}) {
      Register("forward/" + quality + threads,
               PresetEngineOptions(quality, num_threads),
               /*is_view=*/false,
               /*with_color=*/true);
    }
    for (const bool with_color : {false, true}) {
      Register(
          std::string("view/") + (with_color ? "color" : "depth") + threads,
          PresetEngineOptions("medium", num_threads),
          /*is_view=*/true,
          with_color);
    }
  }
}

}  // namespace structnerf
