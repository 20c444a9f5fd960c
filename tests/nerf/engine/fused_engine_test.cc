#include "nerf/engine/grid_engine.h"
#include "nerf/engine/torch_engine.h"
#include "nerf/kernels/half_precision.h"
#include "tests/nerf/engine/random_training.h"
#include "tests/nerf/memory_state.h"
#include "tests/nerf/simd_targets.h"

#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

namespace structnerf {
namespace {

std::vector<RayTile> MakeTiles() {
  std::vector<RayTile> tiles;
  for (const int num_rays : {kMaxTileRays, 1, 0, 17}) {
    tiles.push_back(RandomRays(9, 0, static_cast<int>(tiles.size()), num_rays));
  }
  return tiles;
}

class FusedEngineTest : public SimdTargetTest {};

TEST_P(FusedEngineTest, RendersAsTheOracleDoes) {
  EngineOptions options = MakeOptions(1);
  // Few samples lie close enough to it to be seen differently.
  options.min_color_weight = 1e-3f;
  for (const int num_samples : {1, 16, 37}) {
    options.sampling.num_samples = num_samples;
    const auto fused = MakeFusedEngine(options);
    const auto oracle = MakeTorchEngine(options, TorchPrecision::kDouble);
    ExpectSameRendering(MakeTiles(), fused.get(), oracle.get());
  }
}

// Neither moments nor the density cache nor the weights of levels are left.
TEST_P(FusedEngineTest, RestoredOrRestartedEnginesAreLikeNewOnes) {
  EngineOptions options = MakeOptions(1);
  for (const bool is_fused : {true, false}) {
    const auto make_engine = [&] {
      return is_fused ? MakeFusedEngine(options)
                      : MakeTorchEngine(options, TorchPrecision::kFloat);
    };
    const auto used = make_engine();
    const FieldParameters initial = used->MasterParameters();
    const auto losses = Train(0, 4, used.get());
    const FieldParameters parameters = used->Parameters();
    StepParameters step = MakeStep(4);
    step.level_weights.assign(used->Layout().levels.size(), 0.0f);
    used->Accumulate(step, RandomObjectives(*used, 3, kTileRays));
    used->Update(0.0f, 0.0f);
    EXPECT_EQ(used->Parameters().grid[0], 0);
    EXPECT_EQ(used->MasterParameters().grid, parameters.grid);

    used->Restore(initial);
    EXPECT_EQ(Train(0, 4, used.get()), losses);
    const FieldParameters again = used->Parameters();
    EXPECT_EQ(again.grid, parameters.grid);
    EXPECT_EQ(again.network, parameters.network);

    used->Restart(options.seed + 1);
    EXPECT_NE(used->MasterParameters().grid, initial.grid);
    used->Restart(options.seed);
    EXPECT_EQ(Train(0, 4, used.get()), losses);
  }
}

// Both take the same steps, up to the rounding of table and moments.
TEST_P(FusedEngineTest, TrainsAsTheOracleDoes) {
  const EngineOptions options = MakeOptions(1);
  const auto fused = MakeFusedEngine(options);
  const auto oracle = MakeTorchEngine(options, TorchPrecision::kFloat);
  FieldParameters initial = RandomParameters(fused->Layout(), 1.0f, 5.0f, 1);
  FieldParameters parameters[2];
  RenderEngine* const engines[2] = {fused.get(), oracle.get()};
  for (int i = 0; i < 2; ++i) {
    engines[i]->SetParameters(initial);
    Train(0, 2, engines[i]);
    parameters[i] = engines[i]->Parameters();
  }
  const auto distance = [](const std::vector<float>& a,
                           const std::vector<float>& b) {
    double sum = 0;
    for (size_t i = 0; i < a.size(); ++i) {
      sum += std::pow(static_cast<double>(a[i]) - b[i], 2);
    }
    return std::sqrt(sum);
  };
  EXPECT_LT(distance(parameters[0].grid, parameters[1].grid),
            0.05 * distance(initial.grid, parameters[1].grid));
  EXPECT_LT(distance(parameters[0].network, parameters[1].network),
            0.05 * distance(initial.network, parameters[1].network));
}

STRUCTNERF_FOR_EACH_SIMD_TARGET(FusedEngineTest);

TEST(FusedEngine, ResultsDoNotDependOnTheNumberOfThreads) {
  FieldParameters expected;
  std::vector<double> expected_losses;
  std::vector<RayOutputs> expected_outputs;
  const std::vector<RayTile> tiles = MakeTiles();
  for (const int num_threads : {1, 2, 3, 5}) {
    const auto engine = MakeFusedEngine(MakeOptions(num_threads));
    ASSERT_EQ(engine->NumThreads(), num_threads);
    const std::vector<double> losses = Train(0, 7, engine.get());
    const FieldParameters parameters = engine->Parameters();
    std::vector<RayOutputs> outputs;
    engine->Render(tiles, /*with_color=*/true, &outputs);
    if (num_threads == 1) {
      expected = parameters;
      expected_losses = losses;
      expected_outputs = outputs;
      continue;
    }
    EXPECT_EQ(losses, expected_losses);
    EXPECT_EQ(parameters.grid, expected.grid);
    EXPECT_EQ(parameters.network, expected.network);
    for (size_t tile = 0; tile < tiles.size(); ++tile) {
      for (int ray = 0; ray < tiles[tile].num_rays; ++ray) {
        EXPECT_EQ(outputs[tile].depth[ray], expected_outputs[tile].depth[ray]);
        EXPECT_EQ(outputs[tile].color[1][ray],
                  expected_outputs[tile].color[1][ray]);
      }
    }
  }
}

// A run that is cut in two gives the very numbers of a run in one piece.
TEST(FusedEngine, GoesOnFromASavedState) {
  const auto make_engine = [](const bool is_fused, const int num_threads) {
    return is_fused ? MakeFusedEngine(MakeOptions(num_threads))
                    : MakeTorchEngine(MakeOptions(1), TorchPrecision::kDouble);
  };
  for (const bool is_fused : {true, false}) {
    SCOPED_TRACE(is_fused);
    const auto whole = make_engine(is_fused, 2);
    Train(0, 5, whole.get());
    const FieldParameters parameters = whole->Parameters();
    MemoryState state;
    whole->SaveState(&state);
    const std::vector<double> expected_losses = Train(0, 4, whole.get());
    const FieldParameters expected = whole->Parameters();
    // Training has changed all that was saved.
    MemoryState later_state;
    whole->SaveState(&later_state);
    EXPECT_NE(later_state.bytes, state.bytes);

    const auto resumed = make_engine(is_fused, 3);
    resumed->LoadState(&state);
    EXPECT_EQ(state.NumBytesLeft(), 0u);
    EXPECT_EQ(resumed->Parameters().grid, parameters.grid);
    EXPECT_EQ(Train(0, 4, resumed.get()), expected_losses);
    EXPECT_EQ(resumed->Parameters().grid, expected.grid);
    EXPECT_EQ(resumed->Parameters().network, expected.network);
    MemoryState resumed_state;
    resumed->SaveState(&resumed_state);
    EXPECT_EQ(resumed_state.bytes, later_state.bytes);
  }
}

TEST(FusedEngine, RefusesTheStateOfAnotherLayout) {
  EngineOptions options = MakeOptions(1);
  MemoryState state;
  MakeFusedEngine(options)->SaveState(&state);
  options.field.log2_table_size = 12;
  EXPECT_THROW(MakeFusedEngine(options)->LoadState(&state), std::runtime_error);
  options = MakeOptions(1);
  options.sampling.cache_resolution = 33;
  state.num_read = 0;
  EXPECT_THROW(MakeFusedEngine(options)->LoadState(&state), std::runtime_error);
  state.num_read = 0;
  state.bytes.pop_back();
  EXPECT_THROW(MakeFusedEngine(MakeOptions(1))->LoadState(&state),
               std::runtime_error);
}

TEST(FusedEngine, AccumulatesUntilTheUpdate) {
  const auto both = MakeFusedEngine(MakeOptions(1));
  std::vector<double> sum;
  for (const int step : {0, 1}) {
    both->Accumulate(MakeStep(step), RandomObjectives(*both, 3, kTileRays));
    const auto single = MakeFusedEngine(MakeOptions(1));
    single->Accumulate(MakeStep(step), RandomObjectives(*single, 3, kTileRays));
    const FieldParameters gradients = single->Gradients();
    sum.resize(gradients.grid.size());
    for (size_t i = 0; i < sum.size(); ++i) {
      sum[i] += gradients.grid[i];
    }
  }
  const std::vector<float> accumulated = both->Gradients().grid;
  double largest = 0;
  for (size_t i = 0; i < sum.size(); ++i) {
    ASSERT_NEAR(accumulated[i], sum[i], 1e-5);
    largest = std::max(largest, std::abs(sum[i]));
  }
  EXPECT_GT(largest, 1e-2);
}

TEST(FusedEngine, UpdateClearsTheGradient) {
  const auto engine = MakeFusedEngine(MakeOptions(1));
  engine->Accumulate(MakeStep(0), RandomObjectives(*engine, 3, kTileRays));
  EXPECT_TRUE(engine->Update(1e-2f, 1e-2f));
  const FieldParameters gradients = engine->Gradients();
  for (const std::vector<float>* part : {&gradients.grid, &gradients.network}) {
    for (const float gradient : *part) {
      ASSERT_EQ(gradient, 0.0f);
    }
  }
}

TEST(FusedEngine, GivesBackTheParametersItWasGiven) {
  const auto engine = MakeFusedEngine(MakeOptions(1));
  FieldParameters parameters =
      RandomParameters(engine->Layout(), 1.0f, 5.0f, 1);
  engine->SetParameters(parameters);
  const FieldParameters result = engine->Parameters();
  EXPECT_EQ(result.network, parameters.network);
  for (const GridLevel& level : engine->Layout().levels) {
    for (size_t i = level.first_entry * kGridFeatures;
         i < (level.first_entry + level.num_entries) * kGridFeatures;
         ++i) {
      ASSERT_EQ(result.grid[i], parameters.grid[i]);
    }
  }
}

// Gives one bad derivative.
class BadObjective : public RandomObjective {
 public:
  BadObjective(const float bad, const int bad_tile)
      : RandomObjective(3, kTileRays), bad_(bad), bad_tile_(bad_tile) {}

  void DrawRays(const int step, const int tile, RayTile* rays) override {
    tile_ = tile;
    RandomObjective::DrawRays(step, tile, rays);
  }

  LossValues Evaluate(const RayOutputs& outputs,
                      RayGradients* gradients) override {
    const LossValues losses = RandomObjective::Evaluate(outputs, gradients);
    if (tile_ == bad_tile_) {
      gradients->d_depth[2] = bad_;
      gradients->d_color[0][2] = bad_;
    }
    return losses;
  }

 private:
  const float bad_;
  const int bad_tile_;
  int tile_ = 0;
};

bool AllFinite(const std::vector<float>& values) {
  for (const float value : values) {
    if (!std::isfinite(value)) {
      return false;
    }
  }
  return true;
}

TEST(FusedEngine, RefusesGradientsThatAreNotFinite) {
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(),
                          std::numeric_limits<float>::infinity(),
                          1e30f}) {
    const auto engine = MakeFusedEngine(MakeOptions(2));
    const FieldParameters before = engine->Parameters();
    std::vector<std::unique_ptr<TileObjective>> objectives;
    for (int thread = 0; thread < engine->NumThreads(); ++thread) {
      objectives.push_back(std::make_unique<BadObjective>(bad, 4));
    }
    engine->Accumulate(MakeStep(0), objectives);
    EXPECT_FALSE(engine->Update(1e-2f, 1e-2f)) << bad;
    const FieldParameters after = engine->Parameters();
    EXPECT_EQ(after.network, before.network);
    EXPECT_TRUE(AllFinite(after.grid));
    // The next step starts afresh.
    engine->Accumulate(MakeStep(1), RandomObjectives(*engine, 3, kTileRays));
    EXPECT_TRUE(engine->Update(1e-2f, 1e-2f));
    EXPECT_NE(engine->Parameters().network, before.network);
    EXPECT_TRUE(AllFinite(engine->Parameters().grid));
    EXPECT_TRUE(AllFinite(engine->Parameters().network));
  }
}

TEST(FusedEngine, StepsWithoutRays) {
  const auto engine = MakeFusedEngine(MakeOptions(1));
  const FieldParameters before = engine->Parameters();
  StepParameters step = MakeStep(0);
  step.num_tiles = 0;
  const LossValues losses =
      engine->Accumulate(step, RandomObjectives(*engine, 3, kTileRays));
  EXPECT_EQ(losses, LossValues{});
  EXPECT_TRUE(engine->Update(1e-2f, 1e-2f));
  EXPECT_EQ(engine->Parameters().grid, before.grid);
}

TEST(FusedEngine, ProfileCountsEveryStage) {
  const auto engine = MakeFusedEngine(MakeOptions(2));
  Train(0, 3, engine.get());
  for (const double seconds : engine->Profile()) {
    EXPECT_GT(seconds, 0);
    EXPECT_LT(seconds, 60);
  }
}

}  // namespace
}  // namespace structnerf
