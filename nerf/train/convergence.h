#pragma once

#include "nerf/util/state_stream.h"

#include <vector>

namespace structnerf {

// Notices that a training has nothing more to learn, from measurements at
// pixels that it does not see, always the same ones. Colour alone does not
// tell: it goes on improving long after the surfaces have come to rest, and
// before they have it may rest for a while.
class ConvergenceMonitor {
 public:
  // A measurement finds no change if the error fell by less than this share of
  // itself since the last one, and the depth of half of the pixels changed by
  // less than this share of itself.
  static constexpr double kMinErrorFall = 0.05;
  static constexpr double kMaxDepthChange = 0.004;

  // So many measurements in a row without a change are convergence.
  static constexpr int kNumMeasurements = 2;

  // Takes the mean squared error of colour and the depths, in any unit.
  // Returns whether training has converged.
  bool Measure(double squared_error, const std::vector<float>& depths);

  void SaveState(StateWriter* writer) const;
  void LoadState(StateReader* reader);

 private:
  double last_squared_error_ = -1;  // -1 = nothing was measured yet
  std::vector<float> last_depths_;
  int num_without_change_ = 0;
};

}  // namespace structnerf
