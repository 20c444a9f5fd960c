#include "nerf/train/training_schedule.h"

#include <functional>
#include <vector>

#include <gtest/gtest.h>

namespace structnerf {
namespace {

struct Training {
  int num_steps = 0;
  double seconds = 0;
  std::vector<int> positions;  // of the steps
};

// Trains from `position` on, with steps of this duration, by position.
Training Train(TrainingSchedule* schedule,
               const int num_steps,
               const std::function<double(int)>& duration,
               int position = 0,
               const double begin_seconds = 0) {
  Training training;
  training.seconds = begin_seconds;
  while (position < num_steps) {
    training.positions.push_back(position);
    training.seconds += duration(position);
    const int next = schedule->Next(position, training.seconds);
    EXPECT_GT(next, position);
    EXPECT_LE(next, num_steps);
    position = next;
    ++training.num_steps;
  }
  return training;
}

TEST(TrainingSchedule, WithoutLimitEveryPositionIsTaken) {
  TrainingSchedule schedule(100, 0);
  const Training training = Train(&schedule, 100, [](int) { return 7.0; });
  EXPECT_EQ(training.num_steps, 100);
}

TEST(TrainingSchedule, MoreTimeThanNeededChangesNothing) {
  TrainingSchedule schedule(100, 1000);
  const Training training = Train(&schedule, 100, [](int) { return 1.0; });
  EXPECT_EQ(training.num_steps, 100);
}

TEST(TrainingSchedule, EndsWithTheTime) {
  TrainingSchedule schedule(1000, 100);
  const Training training = Train(&schedule, 1000, [](int) { return 1.0; });
  EXPECT_NEAR(training.seconds, 100, 2);
  // Evenly, whatever the rounding.
  for (int i = 0; i < training.num_steps; ++i) {
    EXPECT_NEAR(training.positions[i], 10 * i, 25) << i;
  }
}

TEST(TrainingSchedule, EndsWithTheTimeThoughStepsBecomeSlower) {
  TrainingSchedule schedule(1000, 100);
  const Training training = Train(&schedule, 1000, [](const int position) {
    return position < 500 ? 0.2 : 1.0;
  });
  EXPECT_NEAR(training.seconds, 100, 3);
  // All phases are there, the last one more coarsely.
  int num_late = 0;
  for (const int position : training.positions) {
    num_late += position >= 500;
  }
  EXPECT_GT(num_late, 20);
  EXPECT_GT(training.positions.back(), 950);
}

TEST(TrainingSchedule, OneLongStepEndsIt) {
  TrainingSchedule schedule(1000, 100);
  const Training training = Train(&schedule, 1000, [](const int position) {
    return position == 0 ? 200.0 : 1.0;
  });
  EXPECT_EQ(training.num_steps, 1);
}

TEST(TrainingSchedule, GoesOnWhereItWas) {
  TrainingSchedule schedule(1000, /*max_seconds=*/40, /*begin_seconds=*/60);
  const Training training = Train(
      &schedule,
      1000,
      [](int) { return 1.0; },
      /*position=*/600,
      /*begin_seconds=*/60);
  EXPECT_NEAR(training.seconds, 100, 2);
  EXPECT_NEAR(training.num_steps, 40, 2);
}

TEST(TrainingSchedule, KeepsTheLargerOfPaceAndLimit) {
  TrainingSchedule unlimited(100, 0);
  unlimited.SetPace(8);
  const Training paced = Train(&unlimited, 100, [](int) { return 1.0; });
  EXPECT_EQ(paced.num_steps, 13);
  EXPECT_EQ(paced.positions[1], 8);
  EXPECT_NEAR(unlimited.SecondsLeft(20, 3), 10, 1e-6);
  TrainingSchedule limited(1000, 50);
  limited.SetPace(8);
  EXPECT_NEAR(Train(&limited, 1000, [](int) { return 1.0; }).num_steps, 50, 2);
}

TEST(TrainingSchedule, TellsTheTimeThatIsLeft) {
  TrainingSchedule unlimited(100, 0);
  EXPECT_EQ(unlimited.SecondsLeft(0, 0), -1);
  unlimited.Next(0, 2);
  EXPECT_NEAR(unlimited.SecondsLeft(1, 2), 198, 1e-6);
  TrainingSchedule limited(100, 50);
  limited.Next(0, 2);
  EXPECT_NEAR(limited.SecondsLeft(4, 2), 48, 1e-6);
  EXPECT_NEAR(limited.SecondsLeft(90, 2), 20, 1e-6);
}

}  // namespace
}  // namespace structnerf
