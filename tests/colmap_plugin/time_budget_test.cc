#include "colmap_plugin/time_budget.h"

#include <gtest/gtest.h>

namespace structnerf {
namespace {

const TimeEstimate kEstimate = {
    /*loading=*/2,
    /*training=*/20,
    /*matching=*/5,
    /*rendering=*/25,
    /*finishing=*/10};

TEST(TimeBudget, WithoutMinutesThereIsNoLimit) {
  EXPECT_FALSE(TimeBudget(0).IsLimited());
  EXPECT_TRUE(TimeBudget(0.1).IsLimited());
}

TEST(TimeBudget, TrainingGetsWhatTheRestLeaves) {
  std::string note;
  const TimeBudget budget(2);
  EXPECT_NEAR(budget.TrainingSeconds(kEstimate, 1, &note), 120 - 40, 1);
  EXPECT_EQ(note, "");
  EXPECT_NEAR(budget.TrainingSeconds(kEstimate, 2, &note), 120 - 80, 1);
  EXPECT_EQ(note, "");
}

TEST(TimeBudget, TooLittleTimeIsSaid) {
  std::string note;
  const TimeBudget budget(0.5);
  EXPECT_NEAR(budget.TrainingSeconds(kEstimate, 1, &note), 5, 1e-9);
  EXPECT_NE(note.find("max_minutes is too short: about 45 s are needed"),
            std::string::npos)
      << note;
}

TEST(TimeBudget, AVeryLongTrainingIsNoReasonToExceedIt) {
  TimeEstimate estimate = kEstimate;
  estimate.training = 1e6;
  std::string note;
  EXPECT_NEAR(TimeBudget(0.5).TrainingSeconds(estimate, 1, &note), 7.5, 1e-9);
  EXPECT_NE(note, "");
}

}  // namespace
}  // namespace structnerf
