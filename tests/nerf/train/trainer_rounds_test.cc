#include "nerf/train/trainer.h"
#include "tests/nerf/train/trainer_fixture.h"
#include "tests/support/temp_dir.h"

#include <algorithm>
#include <chrono>
#include <memory>
#include <thread>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace structnerf {
namespace {

using testing::ElementsAre;

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
    engine_.parameters.network = {1.5f};
    progress_ = RecordingProgress();
    progress_.stop_at = stop_at;
    EXPECT_EQ(Run().num_steps, stop_at);
    EXPECT_EQ(engine_.restore_steps.size(), goes_back ? 1u : 0u);
    EXPECT_EQ(engine_.parameters.network.empty(), stop_at == 190);
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

}  // namespace
}  // namespace structnerf
