#pragma once

namespace structnerf {

// Where in its schedule a training is. Learning rate, level weights and weights
// of losses follow from the position, a number of steps out of `num_steps`.
//
// With a limit to the time, positions are skipped so that the schedule ends
// when the time does, however long steps take: a training that is given half of
// the time it wants goes through the same phases at double speed, rather than
// being cut off with high learning rates. It never goes slower than its pace,
// one position per step unless it is told otherwise: more steps than
// `num_steps` are not taken.
class TrainingSchedule {
 public:
  // `begin_seconds`: of training so far, of one that goes on. `max_seconds`
  // from then on; not positive = no limit.
  TrainingSchedule(int num_steps, double max_seconds, double begin_seconds = 0);

  // The position after a step at `position`. `seconds`: of training in all, up
  // to the end of that step. Returns `num_steps` if training is over.
  int Next(int position, double seconds);

  // From now on at least `pace` positions per step.
  void SetPace(int pace) { pace_ = pace; }

  // Seconds of training that are left, if a step takes as long as the last ones
  // did; -1 = not known yet.
  double SecondsLeft(int position, double seconds) const;

 private:
  const int num_steps_;
  const double end_seconds_;  // of training in all; infinite without limit
  double last_seconds_;       // at the end of the last step
  double step_seconds_ = -1;  // of one step, smoothed; -1 = not known yet
  double carry_ = 0;          // part of a position
  int pace_ = 1;
};

}  // namespace structnerf
