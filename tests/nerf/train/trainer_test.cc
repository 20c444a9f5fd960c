#include "nerf/train/trainer.h"

#include "nerf/train/training_guards.h"
#include "tests/nerf/fake_engine.h"
#include "tests/nerf/plane_scene.h"
#include "tests/support/temp_dir.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <limits>
#include <memory>
#include <thread>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace structnerf {
namespace {

using testing::Each;
using testing::ElementsAre;

// Writes down what it is told, and can stop or abort at a step.
class RecordingProgress : public Progress {
 public:
  void Report(const ProgressUpdate& update) override {
    updates.push_back(update);
  }
  bool ShouldStop() override { return num_stop_asked++ >= stop_at; }
  bool ShouldAbort() override { return num_abort_asked++ >= abort_at; }
  void BlockWhilePaused() override { std::this_thread::sleep_for(pause); }
  bool ShouldSave() override { return should_save; }

  std::vector<ProgressUpdate> updates;
  int num_stop_asked = 0;
  int num_abort_asked = 0;
  int stop_at = std::numeric_limits<int>::max();
  int abort_at = std::numeric_limits<int>::max();
  std::chrono::milliseconds pause{0};  // before each step
  bool should_save = false;
};

class TrainerTest : public testing::Test {
 protected:
  TrainerTest() {
    for (int v = 0; v < 3; ++v) {
      scene_.views.push_back(
          MakeView("view", MakeCamera(16, 12, 12), {0.2 * v, 0, 0}));
      scene_.views.back().image = PlainImage(16, 12, 128);
    }
    scene_.points = {MakePoint(scene_, {0, 0, 4}, {0, 1, 2})};
    options_.training.num_steps = 200;
    options_.training.rays_per_step = 64;
  }

  TrainingSummary Run(const std::vector<int>& test_view_idxs = {}) {
    const SceneFrame frame = ComputeSceneFrame(scene_);
    std::vector<int> train_view_idxs;
    for (int v = 0; v < 3; ++v) {
      if (std::count(test_view_idxs.begin(), test_view_idxs.end(), v) == 0) {
        train_view_idxs.push_back(v);
      }
    }
    TrainingObjective objective(scene_,
                                frame,
                                train_view_idxs,
                                {{}, {}, {}},
                                options_.loss,
                                options_.training);
    Checkpoints checkpoints(checkpoint_options_, scene_);
    return Trainer(&objective, test_view_idxs, options_, &engine_, match_views_)
        .Run(&progress_, /*previews=*/nullptr, &checkpoints);
  }

  Scene scene_;
  ReconstructionOptions options_;
  CheckpointOptions checkpoint_options_;
  FakeEngine engine_;
  RecordingProgress progress_;
  MatchFunction match_views_;
};

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

// Everything of the second run is as if the first had gone on.
TEST_F(TrainerTest, GoesOnFromACheckpoint) {
  scene_.views[1].image = PlainImage(16, 12, 102);
  engine_.color.setConstant(0.3f);
  engine_.loss = [](const int step) {
    return step % 90 == 5 ? std::numeric_limits<double>::infinity()
                          : 1 + 0.01 * step;
  };
  engine_.is_finite = [](const int step) { return step % 50 != 7; };
  const TrainingSummary expected = Run({1});

  const TempDir folder;
  checkpoint_options_.folder = folder.Path();
  progress_ = RecordingProgress();
  progress_.abort_at = 121;
  progress_.should_save = true;
  engine_.steps.clear();
  engine_.grid_learning_rates.clear();
  EXPECT_THROW(Run({1}), Aborted);
  progress_ = RecordingProgress();
  const TrainingSummary summary = Run({1});
  EXPECT_EQ(engine_.num_loaded_updates, 121u);
  ASSERT_EQ(engine_.steps.size(), 200u);
  for (int step = 0; step < 200; ++step) {
    EXPECT_EQ(engine_.steps[step].step, step);
  }
  EXPECT_EQ(summary.num_resumed_steps, 121);
  EXPECT_EQ(summary.num_steps, expected.num_steps);
  EXPECT_EQ(summary.num_rays, expected.num_rays);
  EXPECT_EQ(summary.final_loss, expected.final_loss);
  EXPECT_EQ(summary.guard_counts, expected.guard_counts);
  EXPECT_EQ(summary.guard_counts.at("non_finite_gradient"), 4);
  // The first report after it knows what was known before, but not yet how fast
  // this process is.
  EXPECT_EQ(progress_.updates.front().fraction, 130 / 200.0);
  EXPECT_NEAR(progress_.updates.front().held_out_psnr, 20, 1e-3);
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

TEST_F(TrainerTest, ConvergenceSurvivesAnInterruption) {
  options_.training.stop_when_converged = true;
  const TrainingSummary expected = Run();
  const TempDir folder;
  checkpoint_options_.folder = folder.Path();
  for (const int abort_at : {65, 80}) {
    engine_ = FakeEngine();
    progress_ = RecordingProgress();
    progress_.abort_at = abort_at;
    progress_.should_save = true;
    EXPECT_THROW(Run(), Aborted);
    progress_ = RecordingProgress();
    const TrainingSummary summary = Run();
    EXPECT_GT(summary.num_resumed_steps, 60);
    EXPECT_EQ(summary.num_steps_to_converge, expected.num_steps_to_converge);
    EXPECT_EQ(summary.num_steps, expected.num_steps);
    std::filesystem::remove_all(folder.Path());
    std::filesystem::create_directories(folder.Path());
  }
}

// Maps may have been rendered from it, so nothing is learned after it.
TEST_F(TrainerTest, TrainingThatHasEndedStaysAsItIs) {
  const TempDir folder;
  checkpoint_options_.folder = folder.Path();
  progress_.stop_at = 37;
  const TrainingSummary expected = Run();
  progress_ = RecordingProgress();
  const TrainingSummary summary = Run();
  EXPECT_EQ(engine_.steps.size(), 37u);
  EXPECT_EQ(engine_.num_loaded_updates, 37u);
  EXPECT_TRUE(summary.stopped_early);
  EXPECT_EQ(summary.num_steps, 37);
  EXPECT_EQ(summary.seconds, expected.seconds);
  EXPECT_EQ(summary.final_loss, expected.final_loss);
}

TEST_F(TrainerTest, SavesAtTheInterval) {
  const TempDir folder;
  checkpoint_options_.folder = folder.Path();
  checkpoint_options_.interval_seconds = 1e-9;
  progress_.abort_at = 37;
  EXPECT_THROW(Run(), Aborted);
  EXPECT_EQ(FindCheckpoint(checkpoint_options_).num_steps, 36);
  // Nothing in the following 37 steps is due.
  checkpoint_options_.interval_seconds = 3600;
  progress_.num_abort_asked = 0;
  EXPECT_THROW(Run(), Aborted);
  EXPECT_EQ(FindCheckpoint(checkpoint_options_).num_steps, 36);
  // And none is wanted, though what is there is used.
  checkpoint_options_.interval_seconds = 0;
  progress_ = RecordingProgress();
  EXPECT_EQ(Run().num_resumed_steps, 36);
  EXPECT_EQ(FindCheckpoint(checkpoint_options_).num_steps, 36);
}

// A quarter of the pixels of one of three views.
std::shared_ptr<const MatchedDepth> QuarterOfAView() {
  auto depth = std::make_shared<MatchedDepth>(3);
  for (std::vector<float>& view : *depth) {
    view.assign(16 * 12, 0.0f);
  }
  std::fill_n((*depth)[1].begin(), 16 * 3, 0.5f);
  return depth;
}

TEST_F(TrainerTest, SecondRoundBeginsAnew) {
  std::vector<size_t> match_steps;
  match_views_ = [&](Progress*) {
    match_steps.push_back(engine_.steps.size());
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
    return QuarterOfAView();
  };
  options_.loss.match_fraction = 0.4;
  const TrainingSummary summary = Run();
  EXPECT_THAT(match_steps, ElementsAre(80));
  EXPECT_THAT(engine_.restart_seeds, ElementsAre(options_.training.seed));
  EXPECT_NEAR(summary.confirmed_share, 0.25 / 3, 1e-9);
  EXPECT_EQ(summary.num_steps, 200);
  EXPECT_LT(summary.seconds, 0.5);
  ASSERT_EQ(engine_.steps.size(), 200u);
  EXPECT_EQ(engine_.steps[80].level_weights, engine_.steps[0].level_weights);
  EXPECT_NE(engine_.steps[79].level_weights, engine_.steps[0].level_weights);
  EXPECT_EQ(engine_.grid_learning_rates[80], engine_.grid_learning_rates[0]);
  EXPECT_EQ(engine_.grid_learning_rates[140], engine_.grid_learning_rates[40]);
  EXPECT_LT(engine_.grid_learning_rates[79], engine_.grid_learning_rates[80]);
}

TEST_F(TrainerTest, WithoutMatchingThereIsOneRound) {
  EXPECT_EQ(Run().confirmed_share, -1);
  EXPECT_TRUE(engine_.restart_seeds.empty());
}

// The field of the first round, while the new one is still coarse.
TEST_F(TrainerTest, StoppedEarlyInTheSecondRoundTheBetterFieldStays) {
  match_views_ = [](Progress*) { return QuarterOfAView(); };
  options_.training.coarse_to_fine_fraction = 0.4;
  for (const auto& [stop_at, goes_back] :
       {std::pair(90, false), std::pair(110, true), std::pair(190, false)}) {
    SCOPED_TRACE(stop_at);
    engine_ = FakeEngine();
    engine_.parameters.grid = {1.5f};
    progress_ = RecordingProgress();
    progress_.stop_at = stop_at;
    EXPECT_EQ(Run().num_steps, stop_at);
    EXPECT_EQ(engine_.restore_steps.size(), goes_back ? 1u : 0u);
    EXPECT_EQ(engine_.parameters.grid.empty(), stop_at == 190);
  }
}

TEST_F(TrainerTest, StoppedWhileMatchingTheFieldStays) {
  match_views_ = [&](Progress*) {
    progress_.stop_at = 0;
    return nullptr;
  };
  const TrainingSummary summary = Run();
  EXPECT_EQ(summary.num_steps, 100);
  EXPECT_TRUE(summary.stopped_early);
  EXPECT_EQ(summary.confirmed_share, -1);
  EXPECT_TRUE(engine_.restart_seeds.empty());
}

TEST_F(TrainerTest, SecondRoundSurvivesAnInterruption) {
  int num_matched = 0;
  match_views_ = [&](Progress*) {
    ++num_matched;
    return QuarterOfAView();
  };
  const TempDir folder;
  checkpoint_options_.folder = folder.Path();
  progress_.abort_at = 121;
  progress_.should_save = true;
  EXPECT_THROW(Run(), Aborted);
  progress_ = RecordingProgress();
  const TrainingSummary summary = Run();
  EXPECT_EQ(summary.num_resumed_steps, 121);
  EXPECT_EQ(num_matched, 1);
  EXPECT_NEAR(summary.confirmed_share, 0.25 / 3, 1e-9);
  EXPECT_EQ(engine_.restart_seeds.size(), 1u);
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

TEST_F(TrainerTest, HeldOutPsnr) {
  scene_.views[1].image = PlainImage(16, 12, 102);
  // 0.3 against 0.4 in every channel.
  engine_.color.setConstant(0.3f);
  const TrainingSummary summary = Run({1});
  EXPECT_NEAR(summary.held_out_psnr, 20, 1e-3);
  EXPECT_EQ(progress_.updates.front().held_out_psnr, -1);
  EXPECT_NEAR(progress_.updates.back().held_out_psnr, 20, 1e-3);
  // Now and then on the way.
  EXPECT_NEAR(
      progress_.updates[progress_.updates.size() / 2].held_out_psnr, 20, 1e-3);
}

TEST_F(TrainerTest, HeldOutPsnrKnowsTheExposure) {
  scene_.views[1].image = PlainImage(16, 12, 102);
  scene_.views[1].exposure.gain.setConstant(0.5f);
  scene_.views[1].exposure.offset.setConstant(0.15f);
  engine_.color.setConstant(0.3f);
  EXPECT_NEAR(Run({1}).held_out_psnr, 20, 1e-3);
}

TEST_F(TrainerTest, WithoutHeldOutViewsSinglePixelsAreMeasured) {
  engine_.color.setConstant(0.3f);
  // Only pixel (8, 8) is held out of these images: 0.3 against 0.4.
  for (View& view : scene_.views) {
    for (int c = 0; c < 3; ++c) {
      view.image.data[3 * (8 * 16 + 8) + c] = 102;
    }
  }
  EXPECT_NEAR(Run().held_out_psnr, 20, 1e-3);
  // Nothing is left to measure if it is masked.
  for (View& view : scene_.views) {
    view.mask.assign(16 * 12, 255);
    view.mask[8 * 16 + 8] = 0;
  }
  EXPECT_EQ(Run().held_out_psnr, -1);
}

// More pixels than are measured: a fair choice of them.
TEST_F(TrainerTest, LargeViewsAreSampledEvenly) {
  View& view = scene_.views[1];
  view.camera = MakeCamera(400, 300, 300);
  view.image = PlainImage(400, 300, 0);
  // The right half is white: half of the pixels are entirely wrong.
  for (int row = 0; row < 300; ++row) {
    std::fill_n(view.image.data.begin() + 3 * (row * 400 + 200), 600, 255);
  }
  scene_.points = {MakePoint(scene_, {0, 0, 4}, {0, 1, 2})};
  engine_.color.setZero();
  const double expected = -10 * std::log10(0.5);
  EXPECT_NEAR(Run({1}).held_out_psnr, expected, 0.15);
  EXPECT_LE(engine_.num_rendered_rays, 20u * 8192);
  EXPECT_GE(engine_.num_rendered_rays, 10u * 8192);
}

TEST_F(TrainerTest, PerfectPicturesHaveAFinitePsnr) {
  scene_.views[1].image = PlainImage(16, 12, 255);
  engine_.color.setOnes();
  EXPECT_NEAR(Run({1}).held_out_psnr, 120, 1e-3);
}

TEST_F(TrainerTest, MaskedPixelsAreNotCompared) {
  View& view = scene_.views[1];
  view.image = PlainImage(16, 12, 102);
  view.mask.assign(16 * 12, 255);
  for (int i = 0; i < 100; ++i) {
    view.mask[i] = 0;
    for (int c = 0; c < 3; ++c) {
      view.image.data[3 * i + c] = 255;
    }
  }
  engine_.color.setConstant(0.3f);
  EXPECT_NEAR(Run({1}).held_out_psnr, 20, 1e-3);
  // Nothing left to compare.
  view.mask.assign(16 * 12, 0);
  EXPECT_EQ(Run({1}).held_out_psnr, -1);
}

}  // namespace
}  // namespace structnerf
