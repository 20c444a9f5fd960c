#include "nerf/engine/torch_mlp_engine.h"

#include "nerf/engine/engine_factory.h"
#include "nerf/engine/torch_factory.h"
#include "nerf/field/mlp_layout.h"
#include "tests/nerf/engine/random_scene.h"

#include <cmath>
#include <memory>
#include <numeric>
#include <stdexcept>
#include <vector>

#include <ATen/Parallel.h>
#include <gtest/gtest.h>

namespace structnerf {
namespace {

constexpr int kNumTiles = 4;
constexpr int kTileRays = 6;

EngineOptions MakeOptions(const int num_fine_samples) {
  EngineOptions options;
  options.field.type = "mlp";
  options.field.mlp_num_layers = 3;
  options.field.mlp_width = 16;
  options.sampling.num_samples = 8;
  options.sampling.num_fine_samples = num_fine_samples;
  options.extent = Eigen::Vector3f(1.0f, 0.7f, 0.9f);
  options.initial_density = 3;
  options.min_color_weight = 0;
  return options;
}

// Loss of one step at some parameters, and its gradient.
double Evaluate(const EngineOptions& options,
                const std::vector<float>& parameters,
                std::vector<float>* gradient) {
  const auto engine = MakeTorchMlpEngine(options, TorchPrecision::kDouble);
  engine->SetParameters({{}, parameters});
  StepParameters step;
  step.step = 2;
  step.num_tiles = kNumTiles;
  const LossValues losses =
      engine->Accumulate(step, RandomObjectives(*engine, 5, kTileRays));
  *gradient = engine->Gradients().network;
  return std::accumulate(losses.begin(), losses.end(), 0.0);
}

// Checks the derivative along the gradient over [begin, end) of the
// parameters: it is that part's length.
void ExpectGradient(const EngineOptions& options,
                    const size_t begin,
                    const size_t end) {
  const std::vector<float> parameters =
      InitialMlpParameters(MlpLayout(options.field), options.num_views, 3, 1);
  std::vector<float> gradient;
  Evaluate(options, parameters, &gradient);
  ASSERT_EQ(gradient.size(), parameters.size());
  double norm = 0;
  for (size_t i = begin; i < end; ++i) {
    norm += static_cast<double>(gradient[i]) * gradient[i];
  }
  norm = std::sqrt(norm);
  ASSERT_GT(norm, 1e-2);
  const auto loss_at = [&](const double distance) {
    std::vector<float> moved = parameters;
    for (size_t i = begin; i < end; ++i) {
      moved[i] += static_cast<float>(distance * gradient[i] / norm);
    }
    std::vector<float> ignored;
    return Evaluate(options, moved, &ignored);
  };
  const double h = 1e-3;
  EXPECT_NEAR((loss_at(h) - loss_at(-h)) / (2 * h), norm, 0.01 * norm);
}

TEST(TorchMlpEngine, GradientOfTheCoarseNetworkAlone) {
  const EngineOptions options = MakeOptions(0);
  ExpectGradient(options, 0, MlpLayout(options.field).num_parameters);
}

// Where the fine network is asked depends on the coarse one only.
TEST(TorchMlpEngine, GradientOfTheFineNetwork) {
  const EngineOptions options = MakeOptions(12);
  const size_t count = MlpLayout(options.field).num_parameters;
  ExpectGradient(options, count, 2 * count);
}

// Only colour teaches the coarse network when there is a fine one.
TEST(TorchMlpEngine, CoarseNetworkLearnsColor) {
  EngineOptions options = MakeOptions(12);
  const MlpLayout layout(options.field);
  const std::vector<float> parameters = InitialMlpParameters(layout, 0, 3, 1);
  std::vector<float> gradient;
  Evaluate(options, parameters, &gradient);
  double coarse = 0;
  for (size_t i = 0; i < layout.num_parameters; ++i) {
    coarse += std::abs(gradient[i]);
  }
  EXPECT_GT(coarse, 1e-2);
  options.sampling.num_fine_samples = 0;
  std::vector<float> alone;
  Evaluate(options, parameters, &alone);
  // Layers that colour alone depends on have the same gradient; density also
  // hears of depth when it is alone.
  for (const LayerLayout& layer : {layout.color_hidden, layout.color_output}) {
    for (size_t i = layer.weights; i < layer.biases; ++i) {
      EXPECT_NEAR(gradient[i], alone[i], 1e-5 + 0.15 * std::abs(alone[i]));
    }
  }
  EXPECT_GT(
      std::abs(gradient[layout.density.biases] - alone[layout.density.biases]),
      1e-3);
}

TEST(TorchMlpEngine, ParametersComeBackAndDecideWhatIsRendered) {
  const EngineOptions options = MakeOptions(12);
  const auto first = MakeTorchMlpEngine(options, TorchPrecision::kFloat);
  EngineOptions other_options = options;
  other_options.seed = 9;
  const auto second = MakeTorchMlpEngine(other_options, TorchPrecision::kFloat);
  EXPECT_EQ(first->NumParameters(), first->Parameters().network.size());
  const std::vector<RayTile> tiles = {RandomRays(1, 0, 0, 20),
                                      RandomRays(1, 0, 1, 3)};
  std::vector<RayOutputs> expected;
  std::vector<RayOutputs> outputs;
  first->Render(tiles, /*with_color=*/true, &expected);
  second->Render(tiles, /*with_color=*/true, &outputs);
  EXPECT_NE(outputs[0].depth[0], expected[0].depth[0]);
  second->SetParameters(first->Parameters());
  EXPECT_EQ(second->Parameters().network, first->Parameters().network);
  second->Render(tiles, /*with_color=*/true, &outputs);
  for (size_t tile = 0; tile < tiles.size(); ++tile) {
    for (int ray = 0; ray < tiles[tile].num_rays; ++ray) {
      EXPECT_EQ(outputs[tile].depth[ray], expected[tile].depth[ray]);
      EXPECT_EQ(outputs[tile].color[1][ray], expected[tile].color[1][ray]);
      EXPECT_GT(outputs[tile].depth[ray], tiles[tile].near[ray]);
      EXPECT_LT(outputs[tile].depth[ray], tiles[tile].far[ray]);
    }
  }
}

TEST(TorchMlpEngine, ColorIsLeftAloneUnlessAskedFor) {
  for (const int num_fine_samples : {0, 12}) {
    EngineOptions options = MakeOptions(num_fine_samples);
    options.field.latent_size = 4;
    const auto engine = MakeTorchMlpEngine(options, TorchPrecision::kFloat);
    const std::vector<RayTile> tiles = {RandomRays(1, 0, 0, 20)};
    std::vector<RayOutputs> expected;
    engine->Render(tiles, /*with_color=*/true, &expected);
    std::vector<RayOutputs> outputs(1);
    outputs[0].color[1].fill(-3);
    engine->Render(tiles, /*with_color=*/false, &outputs);
    for (int ray = 0; ray < 20; ++ray) {
      EXPECT_EQ(outputs[0].depth[ray], expected[0].depth[ray]);
      EXPECT_EQ(outputs[0].color[1][ray], -3);
    }
  }
}

// The colour of every ray is to be red and its depth 0.5.
class RedWall : public TileObjective {
 public:
  void DrawRays(const int step, const int tile, RayTile* rays) override {
    *rays = RandomRays(3, step, tile, kMaxTileRays);
    for (int ray = 0; ray < kMaxTileRays; ++ray) {
      rays->near[ray] = 0.1f;
      rays->far[ray] = 1.0f;
    }
  }

  LossValues Evaluate(const RayOutputs& outputs,
                      RayGradients* gradients) override {
    LossValues losses = {};
    for (int ray = 0; ray < kMaxTileRays; ++ray) {
      for (int c = 0; c < 3; ++c) {
        const float difference = outputs.color[c][ray] - (c == 0 ? 1.0f : 0.0f);
        losses[0] += difference * difference;
        gradients->d_color[c][ray] = 2 * difference;
      }
      const float offset = outputs.depth[ray] - 0.5f;
      losses[1] += 10 * offset * offset;
      gradients->d_depth[ray] = 20 * offset;
    }
    return losses;
  }
};

TEST(TorchMlpEngine, RunsOnAsManyThreadsAsTold) {
  const int num_threads = at::get_num_threads();
  EngineOptions options = MakeOptions(4);
  options.num_threads = num_threads + 1;
  MakeTorchMlpEngine(options, TorchPrecision::kFloat);
  EXPECT_EQ(at::get_num_threads(), num_threads + 1);
  options.num_threads = num_threads;
  MakeTorchMlpEngine(options, TorchPrecision::kFloat);
  EXPECT_EQ(at::get_num_threads(), num_threads);
}

TEST(TorchMlpEngine, Learns) {
  const auto engine =
      MakeTorchMlpEngine(MakeOptions(12), TorchPrecision::kFloat);
  std::vector<std::unique_ptr<TileObjective>> objectives;
  objectives.push_back(std::make_unique<RedWall>());
  double first = 0;
  double last = 0;
  for (int i = 0; i < 120; ++i) {
    StepParameters step;
    step.step = i;
    step.num_tiles = 2;
    const LossValues losses = engine->Accumulate(step, objectives);
    last = std::accumulate(losses.begin(), losses.end(), 0.0);
    first = i == 0 ? last : first;
    EXPECT_TRUE(engine->Update(0, 5e-3f));
    engine->RefreshDensityCache(0.5f);  // nothing to do
  }
  EXPECT_LT(last, 0.1 * first);
}

TEST(TorchMlpEngine, GradientsThatAreNotFiniteChangeNothing) {
  class Broken : public RandomObjective {
   public:
    Broken() : RandomObjective(1, 4) {}
    LossValues Evaluate(const RayOutputs& outputs,
                        RayGradients* gradients) override {
      const LossValues losses = RandomObjective::Evaluate(outputs, gradients);
      gradients->d_depth[0] = std::nanf("");
      return losses;
    }
  };
  const auto engine =
      MakeTorchMlpEngine(MakeOptions(12), TorchPrecision::kFloat);
  const std::vector<float> before = engine->Parameters().network;
  std::vector<std::unique_ptr<TileObjective>> objectives;
  objectives.push_back(std::make_unique<Broken>());
  StepParameters step;
  step.num_tiles = 1;
  engine->Accumulate(step, objectives);
  EXPECT_FALSE(engine->Update(0, 1e-2f));
  EXPECT_EQ(engine->Parameters().network, before);
  // The next one counts.
  engine->Accumulate(step, RandomObjectives(*engine, 1, 4));
  EXPECT_TRUE(engine->Update(0, 1e-2f));
  EXPECT_NE(engine->Parameters().network, before);
}

// Two views look at a wall of their own colour from the same places.
class TwoColors : public RedWall {
 public:
  void DrawRays(const int step, const int tile, RayTile* rays) override {
    RedWall::DrawRays(step, tile, rays);
    rays->has_appearance = true;
    for (int ray = 0; ray < kMaxTileRays; ++ray) {
      rays->appearance[0][ray] = ray % 2;
      rays->appearance[1][ray] = ray % 2;
    }
  }

  LossValues Evaluate(const RayOutputs& outputs,
                      RayGradients* gradients) override {
    for (int ray = 0; ray < kMaxTileRays; ++ray) {
      gradients->d_color[0][ray] =
          2 * (outputs.color[0][ray] - (ray % 2 == 0 ? 0.9f : 0.1f));
    }
    return {};
  }
};

TEST(TorchMlpEngine, CodesTellPhotographsApart) {
  EngineOptions options = MakeOptions(12);
  options.field.latent_size = 4;
  options.num_views = 3;
  const auto engine = MakeTorchMlpEngine(options, TorchPrecision::kFloat);
  const size_t num_network_values = 2 * MlpLayout(options.field).num_parameters;
  EXPECT_EQ(engine->NumParameters(), num_network_values + 3 * 4);
  std::vector<std::unique_ptr<TileObjective>> objectives;
  objectives.push_back(std::make_unique<TwoColors>());
  for (int i = 0; i < 150; ++i) {
    StepParameters step;
    step.step = i;
    step.num_tiles = 2;
    engine->Accumulate(step, objectives);
    EXPECT_TRUE(engine->Update(0, 1e-2f));
  }
  // The view that was never drawn has the code of zeros.
  const std::vector<float> parameters = engine->Parameters().network;
  for (int i = 0; i < 12; ++i) {
    EXPECT_EQ(parameters[num_network_values + i] == 0, i >= 8) << i;
  }
  const auto mean_red = [&](const int first, const int second) {
    std::vector<RayTile> tiles(1);
    objectives[0]->DrawRays(1000, 0, &tiles[0]);
    for (int ray = 0; ray < kMaxTileRays; ++ray) {
      tiles[0].appearance[0][ray] = first;
      tiles[0].appearance[1][ray] = second;
    }
    std::vector<RayOutputs> outputs;
    engine->Render(tiles, /*with_color=*/true, &outputs);
    return std::accumulate(
               outputs[0].color[0].begin(), outputs[0].color[0].end(), 0.0) /
           kMaxTileRays;
  };
  EXPECT_GT(mean_red(0, 0), 0.75);
  EXPECT_LT(mean_red(1, 1), 0.25);
  EXPECT_NEAR(mean_red(2, 2), mean_red(-1, -1), 1e-6);
  EXPECT_GT(mean_red(0, 1), mean_red(1, 1));
  EXPECT_LT(mean_red(0, 1), mean_red(0, 0));
}

TEST(EngineFactories, KnowTheirFields) {
  EngineOptions options = MakeOptions(4);
  EXPECT_EQ(MakeAnyEngine(options)->NumParameters(),
            2 * MlpLayout(options.field).num_parameters);
  EXPECT_THROW(MakeGridEngine(options), std::invalid_argument);
  options.field.type = "grid";
  options.field.log2_table_size = 10;
  EXPECT_EQ(MakeAnyEngine(options)->NumParameters(),
            MakeGridEngine(options)->NumParameters());
}

}  // namespace
}  // namespace structnerf
