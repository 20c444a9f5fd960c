// The engine on a device against the one on the CPU.

#include "nerf/cuda/device_engine-inl.h"
#include "tests/nerf/cuda/test_devices.h"
#include "tests/nerf/engine/random_training.h"
#include "tests/nerf/memory_state.h"

#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>

namespace structnerf {
namespace {

double Norm(const std::vector<float>& values) {
  double sum = 0;
  for (const float value : values) {
    sum += static_cast<double>(value) * value;
  }
  return std::sqrt(sum);
}

double RelativeDistance(std::vector<float> actual,
                        const std::vector<float>& expected) {
  for (size_t i = 0; i < actual.size(); ++i) {
    actual[i] -= expected[i];
  }
  return Norm(actual) / Norm(expected);
}

template <class Device>
class DeviceEngineTest : public DeviceTest<Device> {
 protected:
  std::unique_ptr<GridEngine> Make(const EngineOptions& options) {
    return std::make_unique<DeviceEngine<Device>>(
        options, std::make_unique<Device>(), [](const std::string& warning) {
          ADD_FAILURE() << warning;
        });
  }
};

TYPED_TEST_SUITE(DeviceEngineTest, TestDevices);

TYPED_TEST(DeviceEngineTest, RendersAsTheCpuDoes) {
  EngineOptions options = MakeOptions(2);
  options.min_color_weight = 1e-3f;
  for (const int num_samples : {1, 16, 37}) {
    options.sampling.num_samples = num_samples;
    const auto engine = this->Make(options);
    const auto cpu = MakeFusedEngine(options);
    std::vector<RayTile> tiles;
    for (int tile = 0; tile < 300; ++tile) {  // more than a batch
      const int num_rays = tile % 97 == 0 ? 17 : tile % 5;
      tiles.push_back(RandomRays(9, 0, tile, num_rays));
    }
    ExpectSameRendering(tiles, engine.get(), cpu.get());
  }
}

TYPED_TEST(DeviceEngineTest, GradientsAreThoseOfTheCpu) {
  for (const int hidden_width : {16, 64}) {
    for (const int num_levels : {1, 3, 16}) {
      SCOPED_TRACE(testing::Message() << hidden_width << " " << num_levels);
      EngineOptions options = MakeOptions(2);
      options.field.hidden_width = hidden_width;
      options.field.num_levels = num_levels;
      options.min_color_weight = 0;
      const auto engine = this->Make(options);
      const auto cpu = MakeFusedEngine(options);
      const FieldParameters parameters =
          RandomParameters(cpu->Layout(), 1.0f, 5.0f, 1);
      StepParameters step = MakeStep(3);
      for (int level = 0; level < num_levels; ++level) {
        step.level_weights.push_back(1.0f / (1 + level));
      }
      LossValues losses[2];
      FieldParameters gradients[2];
      RenderEngine* const engines[2] = {engine.get(), cpu.get()};
      for (int i = 0; i < 2; ++i) {
        engines[i]->SetParameters(parameters);
        losses[i] = engines[i]->Accumulate(
            step, RandomObjectives(*engines[i], 3, kTileRays));
        gradients[i] = engines[i]->Gradients();
      }
      for (size_t term = 0; term < losses[0].size(); ++term) {
        EXPECT_NEAR(losses[0][term], losses[1][term], 1e-3);
      }
      EXPECT_GT(Norm(gradients[1].grid), 1e-2);
      EXPECT_LT(RelativeDistance(gradients[0].grid, gradients[1].grid), 1e-3);
      EXPECT_LT(RelativeDistance(gradients[0].network, gradients[1].network),
                1e-4);
    }
  }
}

TYPED_TEST(DeviceEngineTest, GradientsAddUpUntilTheUpdate) {
  const auto both = this->Make(MakeOptions(2));
  std::vector<float> sum;
  for (const int step : {0, 1}) {
    both->Accumulate(MakeStep(step), RandomObjectives(*both, 3, kTileRays));
    const auto single = this->Make(MakeOptions(2));
    single->Accumulate(MakeStep(step), RandomObjectives(*single, 3, kTileRays));
    const std::vector<float> gradient = single->Gradients().network;
    sum.resize(gradient.size());
    for (size_t i = 0; i < sum.size(); ++i) {
      sum[i] += gradient[i];
    }
  }
  EXPECT_LT(RelativeDistance(both->Gradients().network, sum), 1e-4);
  EXPECT_TRUE(both->Update(1e-2f, 1e-2f));
  EXPECT_EQ(Norm(both->Gradients().network), 0);
  EXPECT_EQ(Norm(both->Gradients().grid), 0);
}

TYPED_TEST(DeviceEngineTest, TrainsAsTheCpuDoes) {
  const auto engine = this->Make(MakeOptions(2));
  const auto cpu = MakeFusedEngine(MakeOptions(2));
  const FieldParameters initial =
      RandomParameters(cpu->Layout(), 1.0f, 5.0f, 1);
  engine->SetParameters(initial);
  cpu->SetParameters(initial);
  Train(0, 2, engine.get());
  Train(0, 2, cpu.get());
  const FieldParameters actual = engine->Parameters();
  const FieldParameters expected = cpu->Parameters();
  const auto change = [](std::vector<float> after,
                         const std::vector<float>& before) {
    for (size_t i = 0; i < after.size(); ++i) {
      after[i] -= before[i];
    }
    return after;
  };
  EXPECT_LT(RelativeDistance(change(actual.grid, initial.grid),
                             change(expected.grid, initial.grid)),
            0.05);
  EXPECT_LT(RelativeDistance(change(actual.network, initial.network),
                             change(expected.network, initial.network)),
            0.05);
}

TYPED_TEST(DeviceEngineTest, DensityCachesAreThoseOfTheCpu) {
  const auto engine = this->Make(MakeOptions(2));
  const auto cpu = MakeFusedEngine(MakeOptions(2));
  const FieldParameters parameters =
      RandomParameters(cpu->Layout(), 1.0f, 5.0f, 1);
  Progress progress;
  for (GridEngine* each : {engine.get(), cpu.get()}) {
    each->SetParameters(parameters);
    each->RebuildDensityCache(&progress);
  }
  const DensityCache& cache = engine->Cache();
  size_t num_different = 0;
  for (int x = 0; x < cache.Dimensions()[0]; ++x) {
    for (int y = 0; y < cache.Dimensions()[1]; ++y) {
      for (int z = 0; z < cache.Dimensions()[2]; ++z) {
        const size_t cell = cache.CellIndex(x, y, z);
        const int difference = cache.Data()[cell] - cpu->Cache().Data()[cell];
        num_different += difference != 0;
        ASSERT_LE(std::abs(difference), 1);  // rounding of the table
      }
    }
  }
  EXPECT_LT(num_different, cache.NumCells() / 20);
}

TYPED_TEST(DeviceEngineTest, RestoredOrRestartedEnginesAreLikeNewOnes) {
  const EngineOptions options = MakeOptions(2);
  const auto engine = this->Make(options);
  const FieldParameters initial = engine->MasterParameters();
  const std::vector<double> losses = Train(0, 4, engine.get());
  StepParameters step = MakeStep(4);
  step.level_weights.assign(engine->Layout().levels.size(), 0.0f);
  engine->Accumulate(step, RandomObjectives(*engine, 3, kTileRays));
  engine->Update(0.0f, 0.0f);
  EXPECT_EQ(engine->Parameters().grid[0], 0);
  EXPECT_NE(engine->MasterParameters().grid[0], 0);
  const auto expect_losses = [&]() {
    const std::vector<double> again = Train(0, 4, engine.get());
    for (size_t i = 0; i < losses.size(); ++i) {
      // Sums over the grid have no order on a device.
      EXPECT_NEAR(again[i], losses[i], 1e-3);
    }
  };
  engine->Restore(initial);
  expect_losses();
  engine->Restart(options.seed + 1);
  EXPECT_NE(engine->MasterParameters().grid, initial.grid);
  engine->Restart(options.seed);
  EXPECT_EQ(engine->MasterParameters().grid, initial.grid);
  expect_losses();
}

TYPED_TEST(DeviceEngineTest, GoesOnFromASavedState) {
  const auto whole = this->Make(MakeOptions(2));
  Train(0, 5, whole.get());
  MemoryState state;
  whole->SaveState(&state);
  const FieldParameters saved = whole->MasterParameters();
  const std::vector<double> expected = Train(5, 4, whole.get());
  const auto resumed = this->Make(MakeOptions(2));
  resumed->LoadState(&state);
  EXPECT_EQ(state.NumBytesLeft(), 0u);
  EXPECT_EQ(resumed->MasterParameters().grid, saved.grid);
  EXPECT_EQ(resumed->MasterParameters().network, saved.network);
  const std::vector<double> losses = Train(5, 4, resumed.get());
  for (size_t i = 0; i < expected.size(); ++i) {
    EXPECT_NEAR(losses[i], expected[i], 1e-3);
  }

  EngineOptions other = MakeOptions(2);
  other.field.log2_table_size = 12;
  state.num_read = 0;
  EXPECT_THROW(this->Make(other)->LoadState(&state), std::runtime_error);
}

// Gives one bad derivative.
class BadObjective : public RandomObjective {
 public:
  explicit BadObjective(const float bad)
      : RandomObjective(3, kTileRays), bad_(bad) {}

  LossValues Evaluate(const RayOutputs& outputs,
                      RayGradients* gradients) override {
    const LossValues losses = RandomObjective::Evaluate(outputs, gradients);
    gradients->d_depth[2] = bad_;
    return losses;
  }

 private:
  const float bad_;
};

TYPED_TEST(DeviceEngineTest, RefusesGradientsThatAreNotFinite) {
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(),
                          std::numeric_limits<float>::infinity(),
                          1e30f}) {
    const auto engine = this->Make(MakeOptions(2));
    const FieldParameters before = engine->Parameters();
    std::vector<std::unique_ptr<TileObjective>> objectives;
    for (int thread = 0; thread < engine->NumThreads(); ++thread) {
      objectives.push_back(std::make_unique<BadObjective>(bad));
    }
    engine->Accumulate(MakeStep(0), objectives);
    EXPECT_FALSE(engine->Update(1e-2f, 1e-2f)) << bad;
    EXPECT_EQ(engine->Parameters().network, before.network);
    EXPECT_TRUE(std::isfinite(Norm(engine->Parameters().grid)));
    // The next step starts afresh.
    engine->Accumulate(MakeStep(1), RandomObjectives(*engine, 3, kTileRays));
    EXPECT_TRUE(engine->Update(1e-2f, 1e-2f));
    EXPECT_NE(engine->Parameters().network, before.network);
    EXPECT_TRUE(std::isfinite(Norm(engine->Parameters().grid)));
  }
}

TYPED_TEST(DeviceEngineTest, StepsWithoutRays) {
  const auto engine = this->Make(MakeOptions(2));
  const FieldParameters before = engine->Parameters();
  StepParameters step = MakeStep(0);
  step.num_tiles = 0;
  EXPECT_EQ(engine->Accumulate(step, RandomObjectives(*engine, 3, kTileRays)),
            LossValues{});
  EXPECT_TRUE(engine->Update(1e-2f, 1e-2f));
  EXPECT_EQ(engine->Parameters().grid, before.grid);
}

TYPED_TEST(DeviceEngineTest, RefusesMoreLevelsThanKernelsKnow) {
  EngineOptions options = MakeOptions(2);
  options.field.num_levels = 17;
  EXPECT_THROW(this->Make(options), std::invalid_argument);
}

// An engine in little memory.
struct SmallEngine {
  explicit SmallEngine(
      const size_t max_bytes = std::numeric_limits<size_t>::max()) {
    auto owned_device = std::make_unique<HostDevice>(max_bytes);
    device = owned_device.get();
    engine = std::make_unique<DeviceEngine<HostDevice>>(
        MakeOptions(2),
        std::move(owned_device),
        [this](const std::string& warning) { warnings.push_back(warning); });
    num_field_bytes = device->NumBytes();
  }

  // Everything an engine does, in the order of a training.
  void Run() {
    losses = engine->Accumulate(MakeStep(3),
                                RandomObjectives(*engine, 3, kTileRays));
    num_bytes = device->NumBytes();
    gradients = engine->Gradients();
    EXPECT_TRUE(engine->Update(1e-2f, 5e-3f));
    engine->RefreshDensityCache(0.9f);
    std::vector<RayTile> tiles;
    for (int tile = 0; tile < 20; ++tile) {
      tiles.push_back(RandomRays(9, 0, tile, kTileRays));
    }
    engine->Render(tiles, /*with_color=*/true, &outputs);
  }

  HostDevice* device = nullptr;
  std::vector<std::string> warnings;
  std::unique_ptr<GridEngine> engine;
  size_t num_field_bytes = 0;
  size_t num_bytes = 0;
  LossValues losses;
  FieldParameters gradients;
  std::vector<RayOutputs> outputs;
};

TEST(DeviceEngine, HalvesItsBatchesWhereMemoryDoesNotSuffice) {
  SmallEngine whole;
  whole.Run();
  EXPECT_TRUE(whole.warnings.empty());
  const size_t num_batch_bytes = whole.num_bytes - whole.num_field_bytes;
  // At any size, memory ends at another of the buffers.
  constexpr int kNumSizes = 32;
  for (int size = 4; size < kNumSizes; ++size) {
    SmallEngine small(whole.num_field_bytes +
                      num_batch_bytes * size / kNumSizes);
    small.Run();
    ASSERT_FALSE(small.warnings.empty()) << size;
    EXPECT_THAT(small.warnings[0],
                testing::HasSubstr("416 rays at a time; going on with 192."));
    EXPECT_LE(small.warnings.size(), 4u);
    for (size_t term = 0; term < whole.losses.size(); ++term) {
      EXPECT_NEAR(small.losses[term], whole.losses[term], 1e-4);
    }
    EXPECT_LT(RelativeDistance(small.gradients.grid, whole.gradients.grid),
              1e-5);
    EXPECT_LT(
        RelativeDistance(small.gradients.network, whole.gradients.network),
        1e-5);
    for (size_t tile = 0; tile < whole.outputs.size(); ++tile) {
      for (int ray = 0; ray < kTileRays; ++ray) {
        EXPECT_NEAR(small.outputs[tile].depth[ray],
                    whole.outputs[tile].depth[ray],
                    1e-3);
      }
    }
  }
}

TEST(DeviceEngine, SaysSoIfMemoryDoesNotSufficeAtAll) {
  const auto expect_error = [](const std::function<void()>& run) {
    EXPECT_THAT(run,
                testing::ThrowsMessage<DeviceOutOfMemory>(
                    testing::HasSubstr("--StructNeRF.device cpu")));
  };
  const size_t num_field_bytes = SmallEngine().num_field_bytes;
  expect_error([&]() { SmallEngine engine(num_field_bytes - 1); });
  expect_error([&]() { SmallEngine(num_field_bytes + 100).Run(); });
}

}  // namespace
}  // namespace structnerf
