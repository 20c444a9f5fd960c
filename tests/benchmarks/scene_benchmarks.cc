#include "nerf/engine/engine_factory.h"
#include "nerf/engine/render_engine.h"
#include "nerf/progress.h"
#include "nerf/reconstructor.h"
#include "nerf/scene_file.h"
#include "nerf/scene_frame.h"
#include "nerf/util/median.h"
#include "tests/benchmarks/engine_benchmarks.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string>
#include <utility>
#include <vector>

#include <benchmark/benchmark.h>

namespace structnerf {
namespace {

// Looks at the engine's work whenever the training tells how far it is.
class WorkRecorder : public Progress {
 public:
  explicit WorkRecorder(const RenderEngine& engine) : engine_(engine) {}

  void Report(const ProgressUpdate& /*update*/) override {
    const WorkCounts now = engine_.Work();
    if (now.num_rays > last_.num_rays) {
      previous_ = std::exchange(last_, now);
    }
  }

  // Between the last two looks.
  double PerRay(const size_t WorkCounts::*count) const {
    return static_cast<double>(last_.*count - previous_.*count) /
           static_cast<double>(last_.num_rays - previous_.num_rays);
  }

 private:
  const RenderEngine& engine_;
  WorkCounts previous_;
  WorkCounts last_;
};

// Median difference between rendered depth and that of the sparse points where
// views show them, relative to the latter.
double ErrorAtPoints(const Scene& scene, const Reconstructor& reconstructor) {
  Progress silent;
  std::vector<DenseMaps> maps;
  for (size_t v = 0; v < scene.views.size(); ++v) {
    maps.push_back(reconstructor.RenderView(v, &silent));
  }
  std::vector<double> errors;
  for (const SparsePoint& point : scene.points) {
    for (const Observation& observation : point.track) {
      const View& view = scene.views[observation.view_idx];
      const DenseMaps& map = maps[observation.view_idx];
      const int col = static_cast<int>(std::lround(observation.xy.x()));
      const int row = static_cast<int>(std::lround(observation.xy.y()));
      const double z = DepthInView(view, point.xyz);
      if (col >= 0 && row >= 0 && col < map.width && row < map.height) {
        errors.push_back(std::abs(map.depth[row * map.width + col] / z - 1));
      }
    }
  }
  return Median(&errors);
}

void ConvergeOnScene(benchmark::State& state,
                     const std::string& path,
                     const int num_steps) {
  const Scene scene = ReadScene(path);
  ReconstructionOptions options = QualityPreset("medium");
  options.training.num_steps = num_steps;
  options.stereo.num_iterations = 0;
  const RenderEngine* engine = nullptr;
  Reconstructor reconstructor(
      scene, options, [&](const EngineOptions& engine_options) {
        auto made = MakeGridEngine(engine_options);
        engine = made.get();
        return made;
      });
  WorkRecorder recorder(*engine);
  for (auto _ : state) {
    reconstructor.Train(&recorder);
  }
  state.counters["samples/ray"] = recorder.PerRay(&WorkCounts::num_samples);
  state.counters["color_samples/ray"] =
      recorder.PerRay(&WorkCounts::num_color_samples);
  state.counters["gradient_samples/ray"] =
      recorder.PerRay(&WorkCounts::num_gradient_samples);
  state.counters["%error_at_points"] =
      100 * ErrorAtPoints(scene, reconstructor);
}

}  // namespace

void RegisterSceneBenchmarks() {
  const char* const path = std::getenv("STRUCTNERF_SCENE");
  if (path == nullptr) {
    return;
  }
  for (const int num_steps : {150, 300, 600, 1500, 3000}) {
    benchmark::RegisterBenchmark(
        ("scene/steps:" + std::to_string(num_steps)).c_str(),
        [path = std::string(path), num_steps](benchmark::State& state) {
          ConvergeOnScene(state, path, num_steps);
        })
        ->Unit(benchmark::kMillisecond)
        ->Iterations(1)
        ->UseRealTime();
  }
}

}  // namespace structnerf
