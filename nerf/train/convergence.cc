#include "nerf/train/convergence.h"

#include "nerf/util/median.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace structnerf {
namespace {

// Median of |a / b - 1|; 0 of nothing. Depths are not negative.
double MedianChange(const std::vector<float>& depths,
                    const std::vector<float>& last_depths) {
  std::vector<float> changes;
  for (size_t i = 0; i < depths.size(); ++i) {
    const float change =
        std::abs(depths[i] - last_depths[i]) / std::max(last_depths[i], 1e-6f);
    changes.push_back(std::isfinite(change)
                          ? change
                          : std::numeric_limits<float>::infinity());
  }
  return Median(&changes);
}

}  // namespace

bool ConvergenceMonitor::Measure(const double squared_error,
                                 const std::vector<float>& depths) {
  if (last_squared_error_ >= 0) {
    const bool has_changed =
        squared_error < (1 - kMinErrorFall) * last_squared_error_ ||
        !(MedianChange(depths, last_depths_) < kMaxDepthChange);
    num_without_change_ = has_changed ? 0 : num_without_change_ + 1;
  }
  last_squared_error_ = squared_error;
  last_depths_ = depths;
  return num_without_change_ >= kNumMeasurements;
}

void ConvergenceMonitor::SaveState(StateWriter* writer) const {
  writer->WriteValue(last_squared_error_);
  writer->WriteArray(last_depths_);
  writer->WriteValue(num_without_change_);
}

void ConvergenceMonitor::LoadState(StateReader* reader) {
  last_squared_error_ = reader->ReadValue<double>();
  last_depths_ = reader->ReadArray<std::vector<float>>();
  num_without_change_ = reader->ReadValue<int>();
}

}  // namespace structnerf
