#pragma once

#include "colmap_plugin/time_estimate.h"

#include <chrono>
#include <string>

namespace structnerf {

// The time a run was given (StructNerfOptions::max_minutes), from the moment
// this is constructed on, and what of it the training may use.
class TimeBudget {
 public:
  // Not positive = as long as it takes.
  explicit TimeBudget(double max_minutes);

  bool IsLimited() const { return max_seconds_ > 0; }

  // Seconds that training may take now so that what comes after it fits, too.
  // `estimate` is of the whole run, `slowness` how much longer than estimated
  // this machine takes. Never less than a quarter of the whole training or of
  // the time given: maps of a hardly trained field are worth nothing. `note`
  // then says what time the run needs; empty otherwise.
  double TrainingSeconds(const TimeEstimate& estimate,
                         double slowness,
                         std::string* note) const;

 private:
  double ElapsedSeconds() const;

  const double max_seconds_;
  const std::chrono::steady_clock::time_point begin_;
};

}  // namespace structnerf
