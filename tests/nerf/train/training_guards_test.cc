#include "nerf/train/training_guards.h"

#include "tests/nerf/fake_engine.h"
#include "tests/nerf/memory_state.h"
#include "tests/nerf/train/objective_scene.h"

#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace structnerf {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

class TrainingGuardsTest : public testing::Test {
 protected:
  TrainingGuardsTest() : objective_(scene_.MakeObjective()) {
    options_.training.num_steps = 1000;
    options_.training.seed = 40;
    engine_.parameters = {{1.0f, 2.0f}, {3.0f}};
  }

  TrainingGuards MakeGuards() {
    return TrainingGuards(objective_, options_, &engine_);
  }

  // Fails unless `run` throws an error that contains the text.
  static void ExpectStop(const std::function<void()>& run,
                         const std::string& text) {
    try {
      run();
      ADD_FAILURE() << "nothing was thrown";
    } catch (const std::runtime_error& error) {
      EXPECT_THAT(error.what(), HasSubstr(text));
    }
  }

  // Lets a tile be judged with all rays ending at a depth.
  void Evaluate(const float depth) {
    const auto tile = objective_.MakeTileObjective();
    RayTile rays;
    tile->DrawRays(0, 0, &rays);
    RayOutputs outputs = scene_.TrueOutputs(rays);
    outputs.depth.fill(depth);
    RayGradients gradients;
    tile->Evaluate(outputs, &gradients);
  }

  ObjectiveScene scene_;
  TrainingObjective objective_;
  ReconstructionOptions options_;
  FakeEngine engine_;
};

TEST_F(TrainingGuardsTest, HealthyRunIsLeftAlone) {
  TrainingGuards guards = MakeGuards();
  for (int step = 0; step < 1000; ++step) {
    Evaluate(0.5f);
    EXPECT_TRUE(guards.EndStep(step, step + 1, 1.0, true));
  }
  EXPECT_EQ(guards.LearningRateFactor(), 1);
  EXPECT_THAT(engine_.restore_steps, IsEmpty());
  EXPECT_THAT(engine_.restart_seeds, IsEmpty());
  for (const auto& [name, count] : guards.Counts()) {
    EXPECT_EQ(count, 0) << name;
  }
}

TEST_F(TrainingGuardsTest, SingleBadStepsAreCountedOnly) {
  TrainingGuards guards = MakeGuards();
  for (int step = 0; step < 1000; ++step) {
    EXPECT_TRUE(
        guards.EndStep(step, step + 1, step % 50 ? 1.0 : kNan, step % 40 != 0));
  }
  EXPECT_EQ(guards.Counts().at("non_finite_loss"), 20);
  EXPECT_EQ(guards.Counts().at("non_finite_gradient"), 25);
  EXPECT_EQ(guards.Counts().at("restored_snapshot"), 0);
}

TEST_F(TrainingGuardsTest, ManyBadStepsRestoreTheSnapshot) {
  const auto at_start = engine_.parameters;
  TrainingGuards guards = MakeGuards();
  engine_.parameters.grid[0] = 7;
  for (int step = 0; step < TrainingGuards::kMaxBadSteps; ++step) {
    EXPECT_EQ(engine_.parameters.grid[0], 7);
    EXPECT_TRUE(guards.EndStep(step, step + 1, kNan, true));
  }
  EXPECT_EQ(engine_.parameters.grid, at_start.grid);
  EXPECT_EQ(engine_.parameters.network, at_start.network);
  EXPECT_EQ(guards.LearningRateFactor(), 0.5);
  EXPECT_EQ(guards.Counts().at("restored_snapshot"), 1);
}

TEST_F(TrainingGuardsTest, BadParametersRestoreTheLastGoodSnapshot) {
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(),
                          std::numeric_limits<float>::infinity(),
                          -1e5f}) {
    for (const bool is_in_grid : {false, true}) {
      engine_.parameters = {{1.0f, 2.0f}, {3.0f}};
      TrainingGuards guards = MakeGuards();
      const int interval = TrainingGuards::kSnapshotInterval;
      engine_.parameters.network[0] = 4;
      EXPECT_TRUE(guards.EndStep(interval - 1, interval, 1.0, true));
      (is_in_grid ? engine_.parameters.grid : engine_.parameters.network)[0] =
          bad;
      EXPECT_TRUE(guards.EndStep(2 * interval - 1, 2 * interval, 1.0, true));
      EXPECT_THAT(engine_.parameters.grid, ElementsAre(1, 2));
      EXPECT_THAT(engine_.parameters.network, ElementsAre(4));
      EXPECT_EQ(guards.LearningRateFactor(), 0.5);
      EXPECT_EQ(guards.Counts().at("restored_snapshot"), 1);
    }
  }
}

TEST_F(TrainingGuardsTest, StopsAfterTooManyRestores) {
  TrainingGuards guards = MakeGuards();
  const auto restore = [&] {
    for (int i = 0; i < TrainingGuards::kMaxBadSteps; ++i) {
      guards.EndStep(0, 1, 1.0, false);
    }
  };
  for (int i = 0; i < TrainingGuards::kMaxRestores; ++i) {
    restore();
  }
  EXPECT_NEAR(guards.LearningRateFactor(), 1.0 / 1024, 1e-12);
  ExpectStop(restore, "lower grid_learning_rate (now 0.02)");
}

TEST_F(TrainingGuardsTest, DeadFieldStartsOverWithOtherSeeds) {
  TrainingGuards guards = MakeGuards();
  const int warm_up = 100;
  engine_.opacity = 0.005f;
  for (int restart = 0; restart < TrainingGuards::kMaxRestarts; ++restart) {
    for (int step = 0; step < warm_up - 1; ++step) {
      EXPECT_TRUE(guards.EndStep(step, step + 1, 1.0, true));
    }
    EXPECT_FALSE(guards.EndStep(warm_up - 1, warm_up, 1.0, true));
  }
  EXPECT_THAT(engine_.restart_seeds, ElementsAre(41, 42, 43));
  EXPECT_EQ(guards.LearningRateFactor(), 0.125);
  EXPECT_EQ(guards.Counts().at("restarted_dead_field"), 3);
  ExpectStop([&] { guards.EndStep(warm_up - 1, warm_up, 1.0, true); },
             "the field came out empty 4 times");
}

TEST_F(TrainingGuardsTest, FieldThatDiesLaterStartsOver) {
  TrainingGuards guards = MakeGuards();
  engine_.opacity = 0.02f;
  EXPECT_TRUE(guards.EndStep(99, 100, 1.0, true));
  engine_.opacity = std::numeric_limits<float>::quiet_NaN();
  EXPECT_TRUE(guards.EndStep(198, 199, 1.0, true));
  EXPECT_FALSE(guards.EndStep(199, 200, 1.0, true));
}

// A single interval is opaque by definition, so its opacity says nothing.
TEST_F(TrainingGuardsTest, OneSamplePerRayIsNeverDead) {
  options_.sampling.num_samples = 1;
  TrainingGuards guards = MakeGuards();
  engine_.opacity = 0;
  EXPECT_TRUE(guards.EndStep(99, 100, 1.0, true));
}

TEST_F(TrainingGuardsTest, LongTrainingMayBeWithoutValidPatchForHalfOfIt) {
  TrainingGuards guards = MakeGuards();
  for (int i = 0; i < 500; ++i) {
    Evaluate(1e-3f);
    EXPECT_TRUE(guards.EndStep(0, 1, 1.0, true));
  }
  Evaluate(1e-3f);
  ExpectStop([&] { guards.EndStep(0, 1, 1.0, true); }, "in 501 steps");
}

// Of a schedule that a time limit goes through at four times its speed.
TEST_F(TrainingGuardsTest, HalfOfAHurriedTrainingIsFewerSteps) {
  options_.training.num_steps = 6000;
  TrainingGuards guards = MakeGuards();
  for (int i = 0; i < 750; ++i) {
    Evaluate(1e-3f);
    EXPECT_TRUE(guards.EndStep(4 * i, 4 * i + 4, 1.0, true));
  }
  Evaluate(1e-3f);
  ExpectStop([&] { guards.EndStep(3000, 3004, 1.0, true); }, "in 751 steps");
}

TEST_F(TrainingGuardsTest, StepsWithoutValidPatchAreCountedUpToALimit) {
  options_.training.num_steps = 10;
  TrainingGuards guards = MakeGuards();
  // So close that no other view sees it.
  const float too_close = 1e-3f;
  for (int i = 0; i < TrainingGuards::kMaxStepsWithoutPatch; ++i) {
    Evaluate(too_close);
    EXPECT_TRUE(guards.EndStep(0, 1, 1.0, true));
  }
  EXPECT_EQ(guards.Counts().at("step_without_valid_patch"), 200);
  // One that has some starts the count anew.
  Evaluate(0.5f);
  EXPECT_TRUE(guards.EndStep(0, 1, 1.0, true));
  for (int i = 0; i < TrainingGuards::kMaxStepsWithoutPatch; ++i) {
    Evaluate(too_close);
    EXPECT_TRUE(guards.EndStep(0, 1, 1.0, true));
  }
  Evaluate(too_close);
  ExpectStop([&] { guards.EndStep(0, 1, 1.0, true); }, "patch_weight");
}

// What has been counted goes on to count after a checkpoint.
TEST_F(TrainingGuardsTest, GoOnFromASavedState) {
  TrainingGuards guards = MakeGuards();
  for (int step = 0; step < TrainingGuards::kMaxBadSteps + 3; ++step) {
    EXPECT_TRUE(guards.EndStep(step, step + 1, kNan, true));
  }
  MemoryState state;
  guards.SaveState(&state);
  const FieldParameters snapshot = engine_.parameters;
  engine_.parameters = {{7.0f, 8.0f}, {9.0f}};
  TrainingGuards resumed = MakeGuards();
  resumed.LoadState(&state);
  EXPECT_EQ(state.NumBytesLeft(), 0u);
  EXPECT_EQ(resumed.Counts(), guards.Counts());
  EXPECT_EQ(resumed.LearningRateFactor(), 0.5);
  // Three bad steps are known already.
  const int num_more = TrainingGuards::kMaxBadSteps - 3;
  for (int step = 0; step < num_more; ++step) {
    EXPECT_EQ(resumed.Counts().at("restored_snapshot"), 1);
    EXPECT_TRUE(resumed.EndStep(30 + step, 30 + step + 1, kNan, true));
  }
  EXPECT_EQ(resumed.Counts().at("restored_snapshot"), 2);
  EXPECT_EQ(engine_.parameters.grid, snapshot.grid);

  engine_.parameters.grid.push_back(0.0f);
  state.num_read = 0;
  EXPECT_THROW(MakeGuards().LoadState(&state), std::runtime_error);
}

}  // namespace
}  // namespace structnerf
