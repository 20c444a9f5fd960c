#include "nerf/train/trainer.h"
#include "tests/nerf/train/trainer_fixture.h"
#include "tests/support/temp_dir.h"

#include <filesystem>
#include <limits>

#include <gtest/gtest.h>

namespace structnerf {
namespace {

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

}  // namespace
}  // namespace structnerf
