#include "nerf/train/training_schedule.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace structnerf {
namespace {

// Weight of the last step in the mean duration.
constexpr double kSmoothing = 0.1;

}  // namespace

TrainingSchedule::TrainingSchedule(const int num_steps,
                                   const double max_seconds,
                                   const double begin_seconds)
    : num_steps_(num_steps),
      end_seconds_(max_seconds > 0 ? begin_seconds + max_seconds
                                   : std::numeric_limits<double>::infinity()),
      last_seconds_(begin_seconds) {}

int TrainingSchedule::Next(const int position, const double seconds) {
  const double duration = seconds - last_seconds_;
  last_seconds_ = seconds;
  step_seconds_ = step_seconds_ < 0 ? duration
                                    : (1 - kSmoothing) * step_seconds_ +
                                          kSmoothing * duration;
  const double left = end_seconds_ - seconds;
  if (left <= 0) {
    return num_steps_;
  }
  // The share of the time that is left, before the step, which a step takes.
  const double share = step_seconds_ / (left + step_seconds_);
  const double advance =
      std::max<double>(pace_, carry_ + share * (num_steps_ - position));
  const double whole = std::floor(advance);
  carry_ = advance - whole;
  return std::min(num_steps_, position + static_cast<int>(whole));
}

double TrainingSchedule::SecondsLeft(const int position,
                                     const double seconds) const {
  if (step_seconds_ < 0) {
    return -1;
  }
  return std::max(0.0,
                  std::min(step_seconds_ * (num_steps_ - position) / pace_,
                           end_seconds_ - seconds));
}

}  // namespace structnerf
