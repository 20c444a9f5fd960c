#include "nerf/train/trainer.h"

#include "nerf/train/training_guards.h"
#include "tests/nerf/train/trainer_fixture.h"

#include <chrono>
#include <limits>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace structnerf {
namespace {

using testing::Each;
using testing::ElementsAre;

TEST_F(TrainerTest, RunsEveryStepOnce) {
  const TrainingSummary summary = Run();
  EXPECT_EQ(summary.num_steps, 200);
  EXPECT_FALSE(summary.stopped_early);
  ASSERT_EQ(engine_.steps.size(), 200u);
  for (int step = 0; step < 200; ++step) {
    EXPECT_EQ(engine_.steps[step].step, step);
    EXPECT_EQ(engine_.steps[step].num_tiles, 2);
  }
  EXPECT_EQ(summary.num_rays, 200u * 64);
  EXPECT_EQ(summary.num_samples, 200u * 64 * options_.sampling.num_samples);
  EXPECT_EQ(summary.num_parameters, engine_.NumParameters());
  EXPECT_NEAR(summary.final_loss, 1, 1e-6);
  EXPECT_GT(summary.seconds, 0);
}

TEST_F(TrainerTest, LearningRatesFallExponentially) {
  options_.training.grid_learning_rate = 0.1;
  options_.training.network_learning_rate = 0.01;
  options_.training.final_learning_rate_factor = 0.25;
  Run();
  EXPECT_NEAR(engine_.grid_learning_rates[0], 0.1, 1e-7);
  EXPECT_NEAR(engine_.grid_learning_rates[100], 0.05, 1e-7);
  EXPECT_NEAR(engine_.grid_learning_rates[199], 0.025, 5e-4);
  for (int step = 0; step < 200; ++step) {
    EXPECT_NEAR(engine_.network_learning_rates[step],
                0.1 * engine_.grid_learning_rates[step],
                1e-7);
  }
}

TEST_F(TrainerTest, LevelsComeInFromCoarseToFine) {
  options_.training.coarse_to_fine_fraction = 0.6125;
  Run();
  std::vector<int> first_step(4, -1);
  std::vector<float> last(4, 0.0f);
  for (const StepParameters& step : engine_.steps) {
    ASSERT_EQ(step.level_weights.size(), 4u);
    for (int level = 0; level < 4; ++level) {
      const float weight = step.level_weights[level];
      EXPECT_GE(weight, last[level]);
      EXPECT_LE(weight, 1);
      if (weight > 0 && first_step[level] < 0) {
        first_step[level] = step.step;
      }
      last[level] = weight;
    }
  }
  EXPECT_THAT(last, Each(1.0f));
  // The others after 20.4, 40.8 and 61.3 % of the steps.
  EXPECT_THAT(first_step, ElementsAre(0, 41, 82, 123));
}

TEST_F(TrainerTest, OneLevelIsAlwaysOn) {
  options_.field.num_levels = 1;
  engine_ = FakeEngine();
  Run();
  for (const StepParameters& step : engine_.steps) {
    EXPECT_THAT(step.level_weights, ElementsAre(1.0f));
  }
}

TEST_F(TrainerTest, DensityCacheIsRefreshedRegularly) {
  options_.sampling.cache_interval = 60;
  Run();
  EXPECT_THAT(engine_.refresh_steps, ElementsAre(60, 120, 180));
}

TEST_F(TrainerTest, ProgressRisesToOne) {
  Run();
  ASSERT_GT(progress_.updates.size(), 10u);
  double last = 0;
  for (const ProgressUpdate& update : progress_.updates) {
    EXPECT_EQ(update.stage, "Training");
    EXPECT_GE(update.fraction, last);
    EXPECT_LE(update.fraction, 1);
    last = update.fraction;
  }
  EXPECT_EQ(progress_.updates.front().seconds_left, -1);
  EXPECT_GE(progress_.updates[1].seconds_left, 0);
  EXPECT_EQ(progress_.updates.back().fraction, 1);
  EXPECT_EQ(progress_.updates.back().seconds_left, 0);
  EXPECT_NEAR(progress_.updates.back().loss, 1, 1e-6);
}

// However long a step takes, the user's wish is looked at before each.
TEST_F(TrainerTest, StopsAtTheStepWhenAsked) {
  progress_.stop_at = 37;
  const TrainingSummary summary = Run();
  EXPECT_TRUE(summary.stopped_early);
  EXPECT_EQ(summary.num_steps, 37);
  EXPECT_EQ(engine_.steps.size(), 37u);
  EXPECT_EQ(progress_.updates.back().fraction, 1);
}

TEST_F(TrainerTest, StopsBeforeTheFirstStep) {
  progress_.stop_at = 0;
  const TrainingSummary summary = Run();
  EXPECT_TRUE(summary.stopped_early);
  EXPECT_EQ(summary.num_steps, 0);
  EXPECT_TRUE(std::isnan(summary.final_loss));
}

// A likelihood is a loss that may be negative.
TEST_F(TrainerTest, NegativeLossesAreSmoothed) {
  engine_.loss = [](const int step) { return step < 100 ? -1.0 : 0.0; };
  const TrainingSummary summary = Run();
  EXPECT_NEAR(summary.final_loss, -std::pow(0.98, 100), 1e-6);
}

TEST_F(TrainerTest, AbortsAtTheStepWhenAsked) {
  progress_.abort_at = 37;
  EXPECT_THROW(Run(), Aborted);
  EXPECT_EQ(engine_.steps.size(), 37u);
}

TEST_F(TrainerTest, PausesAreNotCountedAsTraining) {
  options_.training.num_steps = 20;
  progress_.pause = std::chrono::milliseconds(50);
  const auto begin = std::chrono::steady_clock::now();
  const TrainingSummary summary = Run();
  EXPECT_GE(std::chrono::steady_clock::now() - begin, std::chrono::seconds(1));
  EXPECT_LT(summary.seconds, 0.5);
  for (const ProgressUpdate& update : progress_.updates) {
    EXPECT_LT(update.seconds_left, 0.5);
  }
}

// What this engine renders never changes.
TEST_F(TrainerTest, HastensOnceItHasConverged) {
  EXPECT_EQ(Run().num_steps_to_converge, -1);
  engine_ = FakeEngine();
  options_.training.stop_when_converged = true;
  const TrainingSummary summary = Run();
  // Measured from 0.25 on, every 0.05.
  EXPECT_EQ(summary.num_steps_to_converge, 70);
  EXPECT_EQ(summary.num_steps, 71 + (199 - 70) / 8);
  ASSERT_EQ(engine_.steps.size(), static_cast<size_t>(summary.num_steps));
  EXPECT_EQ(engine_.steps[70].step, 70);
  EXPECT_EQ(engine_.steps[71].step, 78);
  EXPECT_GE(engine_.steps.back().step, 192);
}

TEST_F(TrainerTest, GuardsAreCounted) {
  engine_.is_finite = [](const int step) { return step % 50 != 7; };
  engine_.loss = [](const int step) {
    return step == 3 ? std::numeric_limits<double>::quiet_NaN() : 2.0;
  };
  const TrainingSummary summary = Run();
  EXPECT_EQ(summary.guard_counts.at("non_finite_gradient"), 4);
  EXPECT_EQ(summary.guard_counts.at("non_finite_loss"), 1);
  // The mean is not spoilt for the rest of the run.
  EXPECT_NEAR(summary.final_loss, 2, 1e-6);
}

TEST_F(TrainerTest, RestoredSnapshotHalvesTheLearningRates) {
  options_.training.final_learning_rate_factor = 1;
  engine_.is_finite = [](const int update) {
    return update < 20 || update >= 20 + TrainingGuards::kMaxBadSteps;
  };
  const TrainingSummary summary = Run();
  EXPECT_EQ(summary.num_steps, 200);
  EXPECT_EQ(summary.guard_counts.at("restored_snapshot"), 1);
  EXPECT_THAT(engine_.restore_steps,
              ElementsAre(20 + TrainingGuards::kMaxBadSteps));
  EXPECT_EQ(engine_.grid_learning_rates[199],
            0.5f * engine_.grid_learning_rates[0]);
  EXPECT_EQ(engine_.network_learning_rates[199],
            0.5f * engine_.network_learning_rates[0]);
}

TEST_F(TrainerTest, DeadFieldStartsOver) {
  engine_.opacity = 0;
  engine_.loss = [&](const int step) {
    if (step == 0 && !engine_.restart_seeds.empty()) {
      engine_.opacity = 1;
    }
    return engine_.restart_seeds.empty() ? 9.0 : 1.0;
  };
  const TrainingSummary summary = Run();
  EXPECT_EQ(summary.guard_counts.at("restarted_dead_field"), 1);
  EXPECT_EQ(summary.num_steps, 20 + 200);
  ASSERT_EQ(engine_.steps.size(), 220u);
  EXPECT_EQ(engine_.steps[20].step, 0);
  EXPECT_EQ(engine_.steps.back().step, 199);
  EXPECT_NEAR(summary.final_loss, 1, 1e-6);
}

}  // namespace
}  // namespace structnerf
