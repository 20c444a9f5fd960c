#pragma once

#include "nerf/engine/render_engine.h"

#include <functional>
#include <memory>
#include <vector>

namespace structnerf {

// An engine that renders what it is told and writes down what is asked of it.
class FakeEngine : public RenderEngine {
 public:
  // Depth of a ray in field units, by tile and ray.
  std::function<float(const RayTile& rays, int ray)> depth =
      [](const RayTile&, int) { return 0.5f; };

  // Standard deviation divided by depth.
  std::function<float(const RayTile& rays, int ray)> relative_std =
      [](const RayTile&, int) { return 0.0f; };

  Eigen::Vector3f color = Eigen::Vector3f::Zero();
  float opacity = 1;
  FieldParameters parameters;

  // What Accumulate() and Update() return, by step.
  std::function<double(int step)> loss = [](int) { return 1.0; };
  std::function<bool(int step)> is_finite = [](int) { return true; };

  std::vector<StepParameters> steps;
  std::vector<float> grid_learning_rates;
  std::vector<float> network_learning_rates;
  std::vector<int> refresh_steps;  // number of updates before each refresh
  std::vector<int> restore_steps;  // likewise
  std::vector<int> restart_seeds;
  size_t num_rendered_rays = 0;
  size_t num_rendered_tiles = 0;
  size_t num_loaded_updates = 0;

  size_t NumParameters() const override { return 1234; }

  LossValues Accumulate(
      const StepParameters& step,
      const std::vector<std::unique_ptr<TileObjective>>&) override {
    steps.push_back(step);
    LossValues losses = {};
    losses[0] = 0.25 * loss(step.step);
    losses[1] = 0.75 * loss(step.step);
    return losses;
  }

  bool Update(const float grid_learning_rate,
              const float network_learning_rate) override {
    grid_learning_rates.push_back(grid_learning_rate);
    network_learning_rates.push_back(network_learning_rate);
    return is_finite(static_cast<int>(grid_learning_rates.size()) - 1);
  }

  void RefreshDensityCache(float) override {
    refresh_steps.push_back(static_cast<int>(grid_learning_rates.size()));
  }

  void Render(const std::vector<RayTile>& tiles,
              const bool with_color,
              std::vector<RayOutputs>* outputs) override {
    outputs->resize(tiles.size());
    num_rendered_tiles += tiles.size();
    for (size_t tile = 0; tile < tiles.size(); ++tile) {
      RayOutputs& output = (*outputs)[tile];
      for (int ray = 0; ray < tiles[tile].num_rays; ++ray) {
        ++num_rendered_rays;
        output.depth[ray] = depth(tiles[tile], ray);
        const float std = relative_std(tiles[tile], ray) * output.depth[ray];
        output.depth_variance[ray] = std * std;
        output.opacity[ray] = opacity;
        if (with_color) {
          for (int c = 0; c < 3; ++c) {
            output.color[c][ray] = color[c];
          }
        }
      }
    }
  }

  FieldParameters Parameters() const override { return parameters; }
  void SetParameters(const FieldParameters& values) override {
    parameters = values;
  }
  FieldParameters MasterParameters() const override { return parameters; }
  void Restore(const FieldParameters& values) override {
    parameters = values;
    restore_steps.push_back(static_cast<int>(grid_learning_rates.size()));
  }
  void Restart(const int seed) override {
    parameters = {};
    restart_seeds.push_back(seed);
  }
  FieldParameters Gradients() const override { return {}; }

  // Its state is the number of updates.
  void SaveState(StateWriter* writer) const override {
    writer->WriteValue(grid_learning_rates.size());
  }
  void LoadState(StateReader* reader) override {
    num_loaded_updates = reader->ReadValue<size_t>();
  }
  int NumThreads() const override { return 1; }
};

}  // namespace structnerf
