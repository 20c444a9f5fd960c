// Rates far too large, and schedules of very long and very short runs.

#include "nerf/train/checkpoint.h"
#include "nerf/train/trainer.h"
#include "tests/nerf/fake_engine.h"
#include "tests/stability/room_run.h"
#include "tests/stability/stability_case.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

namespace structnerf {
namespace {

// Looks at what the trainer asks for and keeps nothing.
class ScheduleEngine : public FakeEngine {
 public:
  LossValues Accumulate(
      const StepParameters& step,
      const std::vector<std::unique_ptr<TileObjective>>& objectives) override {
    RequireStable(step.step == num_steps, "a step was left out");
    level_weights.resize(step.level_weights.size(), 0);
    for (size_t level = 0; level < level_weights.size(); ++level) {
      const float weight = step.level_weights[level];
      RequireStable(weight >= level_weights[level] && weight <= 1,
                    "the weight of a level is " + ShortNumber(weight));
      level_weights[level] = weight;
    }
    ++num_steps;
    // The hints' own schedule.
    if (num_steps % 1000 == 1) {
      RayTile rays;
      objectives[0]->DrawRays(step.step, 0, &rays);
      RayOutputs outputs = {};
      outputs.depth.fill(0.3f);
      RayGradients gradients;
      for (const double loss : objectives[0]->Evaluate(outputs, &gradients)) {
        RequireStable(std::isfinite(loss) && loss >= 0,
                      "a loss is " + ShortNumber(loss));
      }
    }
    return {};
  }

  bool Update(const float grid_learning_rate,
              const float network_learning_rate) override {
    RequireStable(grid_learning_rate <= last_rate && grid_learning_rate > 0 &&
                      network_learning_rate > 0,
                  "a learning rate is " + ShortNumber(grid_learning_rate));
    first_rate = first_rate == 0 ? grid_learning_rate : first_rate;
    last_rate = grid_learning_rate;
    return true;
  }

  void RefreshDensityCache(float) override {}

  int num_steps = 0;
  std::vector<float> level_weights;
  float first_rate = 0;
  float last_rate = 1e9f;
};

std::string MeasureSchedule(const int num_steps) {
  ReconstructionOptions options = StabilityOptions();
  options.training.num_steps = num_steps;
  options.loss.prior_weight = 0.1;
  const Scene& scene = StabilityScene();
  const SceneFrame frame = ComputeSceneFrame(scene);
  std::vector<int> view_idxs;
  std::vector<std::vector<int>> sources;
  for (size_t v = 0; v < scene.views.size(); ++v) {
    view_idxs.push_back(static_cast<int>(v));
    sources.push_back({static_cast<int>(v == 0)});
  }
  TrainingObjective objective(
      scene, frame, view_idxs, sources, options.loss, options.training);
  ScheduleEngine engine;
  Progress progress;
  Checkpoints none(CheckpointOptions(), scene);
  Trainer(&objective, {}, options, &engine).Run(&progress, nullptr, &none);
  RequireStable(engine.num_steps == num_steps, "steps are missing");
  const double ratio = engine.last_rate / engine.first_rate;
  const double expected =
      std::pow(options.training.final_learning_rate_factor,
               static_cast<double>(num_steps - 1) / num_steps);
  RequireStable(std::abs(ratio / expected - 1) < 1e-5,
                "rates fall to " + ShortNumber(ratio));
  // As few steps as one leave no time for the finer levels.
  RequireStable(
      num_steps < 100 || *std::min_element(engine.level_weights.begin(),
                                           engine.level_weights.end()) == 1,
      "levels are missing at the end");
  return "rates fall to " + ShortNumber(ratio) + " of the first, " +
         ShortNumber(std::abs(ratio / expected - 1)) + " off; all levels in";
}

std::string MeasureRates(const double factor, const double max_error) {
  ReconstructionOptions options = StabilityOptions();
  options.training.num_steps = 400;
  options.training.grid_learning_rate *= factor;
  options.training.network_learning_rate *= factor;
  return MeasureScene(StabilityScene(), options, max_error);
}

}  // namespace

std::vector<StabilityCase> TrainingCases() {
  // What learns nothing may be anywhere.
  constexpr double kAnyDepth = std::numeric_limits<double>::max();
  std::vector<StabilityCase> cases;
  cases.push_back(
      {"the room as it is",
       [] { return MeasureScene(StabilityScene(), StabilityOptions(), 15); }});
  cases.push_back({"learning rates 10 times too large",
                   [] { return MeasureRates(10, 20); }});
  cases.back().is_slow = true;
  cases.push_back({"learning rates 100 times too large",
                   [] { return MeasureRates(100, kAnyDepth); }});
  cases.push_back({"learning rates 1e4 times too large",
                   [] { return MeasureRates(1e4, kAnyDepth); },
                   "lower grid_learning_rate",
                   /*is_refusal_optional=*/true});
  cases.push_back(
      {"learning rates of zero", [] { return MeasureRates(0, kAnyDepth); }});
  cases.push_back({"all loss weights 1e6", [] {
                     ReconstructionOptions options = StabilityOptions();
                     options.loss.color_weight = 1e6;
                     options.loss.patch_weight = 1e6;
                     options.loss.planar_weight = 1e6;
                     options.loss.sparse_weight = 1e6;
                     options.loss.prior_weight = 1e6;
                     return MeasureScene(StabilityScene(), options, 60);
                   }});
  cases.push_back({"all loss weights 1e-30", [] {
                     ReconstructionOptions options = StabilityOptions();
                     options.loss.color_weight = 1e-30;
                     options.loss.patch_weight = 1e-30;
                     options.loss.planar_weight = 1e-30;
                     options.loss.sparse_weight = 1e-30;
                     options.loss.prior_weight = 1e-30;
                     return MeasureScene(StabilityScene(), options, 60);
                   }});
  for (const int num_steps : {1, 7, 1000000}) {
    cases.push_back({"schedule of " + std::to_string(num_steps) + " steps",
                     [=] { return MeasureSchedule(num_steps); }});
  }
  return cases;
}

}  // namespace structnerf
