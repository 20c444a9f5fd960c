#include "nerf/progress.h"
#include "nerf/stereo/patch_match.h"
#include "nerf/util/cpu_time.h"
#include "tests/benchmarks/engine_benchmarks.h"
#include "tests/nerf/plane_scene.h"

#include <cmath>

#include <benchmark/benchmark.h>

namespace structnerf {
namespace {

constexpr int kWidth = 320;
constexpr int kHeight = 240;
constexpr int kNumViews = 9;
constexpr float kSeedError = 1.03f;

// A wall seen by cameras side by side.
Scene MakeWall() {
  TexturedPlane plane;
  plane.normal = Eigen::Vector3d(0.3, -0.2, -1);
  Scene scene;
  for (int i = 0; i < kNumViews; ++i) {
    const double x = 0.15 * (i - kNumViews / 2);
    scene.views.push_back(MakeView("view",
                                   MakeCamera(kWidth, kHeight, 300),
                                   Eigen::Vector3d(x, 0.3 * std::sin(i), 0)));
    plane.Photograph(kWidth, kHeight, &scene.views.back());
  }
  return scene;
}

// Matches the first view with the others, from planes that face the camera a
// little off the wall's middle.
void Match(benchmark::State& state, const std::string& quality) {
  const Scene scene = MakeWall();
  SceneFrame frame;
  frame.scale = 0.1;
  const TrainingViews views(scene, frame);
  std::vector<std::vector<int>> sources(kNumViews);
  for (int i = 1; i < kNumViews; ++i) {
    sources[0].push_back(i);
  }
  const StereoOptions options = QualityPreset(quality).stereo;
  const PatchMatch patch_match(scene, frame, views, sources, options);
  PlaneMaps seed;
  seed.width = kWidth;
  seed.height = kHeight;
  const size_t num_pixels = size_t{kWidth} * kHeight;
  seed.rho.assign(num_pixels,
                  static_cast<float>(kSeedError / (4 * frame.scale)));
  seed.rho_x.assign(num_pixels, 0.0f);
  seed.rho_y.assign(num_pixels, 0.0f);
  ThreadPool pool(1);
  Progress silent;
  PlaneMaps maps;
  const double cpu_before = ProcessCpuSeconds();
  for (auto _ : state) {
    maps = seed;
    patch_match.Refine(0, &pool, &silent, &maps);
  }
  const double cpu_seconds = ProcessCpuSeconds() - cpu_before;
  double sum_cost = 0;
  for (const float cost : maps.cost) {
    sum_cost += cost;
  }
  state.counters["cpu_kilopixels/s"] =
      1e-3 * static_cast<double>(num_pixels * state.iterations()) / cpu_seconds;
  state.counters["mean_cost"] = sum_cost / static_cast<double>(num_pixels);
}

}  // namespace

void RegisterStereoBenchmarks() {
  for (const std::string quality : {"medium", "high"}) {
    benchmark::RegisterBenchmark(
        ("match/" + quality).c_str(),
        [=](benchmark::State& state) { Match(state, quality); })
        ->Unit(benchmark::kMillisecond);
  }
}

}  // namespace structnerf
