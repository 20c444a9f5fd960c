#include "colmap_plugin/time_budget.h"

#include "colmap_plugin/text_output.h"

#include <algorithm>

namespace structnerf {

TimeBudget::TimeBudget(const double max_minutes)
    : max_seconds_(60 * max_minutes),
      begin_(std::chrono::steady_clock::now()) {}

double TimeBudget::TrainingSeconds(const TimeEstimate& estimate,
                                   const double slowness,
                                   std::string* note) const {
  const double after =
      slowness * (estimate.matching + estimate.rendering + estimate.finishing);
  const double left = max_seconds_ - ElapsedSeconds() - after;
  const double least =
      kMinTrainingShare * std::min(slowness * estimate.training, max_seconds_);
  note->clear();
  if (left >= least) {
    return left;
  }
  *note = "The time given by --StructNeRF.max_minutes is too short: about " +
          DurationText(max_seconds_ - left + least) +
          " are needed; choose a lower --StructNeRF.quality.";
  return least;
}

double TimeBudget::ElapsedSeconds() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() -
                                       begin_)
      .count();
}

}  // namespace structnerf
