#pragma once

#include "nerf/engine/render_engine.h"
#include "nerf/options.h"
#include "nerf/train/training_objective.h"
#include "nerf/util/state_stream.h"

#include <map>
#include <string>

namespace structnerf {

// Watches the numerics of a training run and repairs what it can:
//
//   sign of trouble                    what is done
//   loss or gradient not finite        those parameters skip the step
//   kMaxBadSteps of these since the    the last snapshot of the parameters is
//   last snapshot, or a parameter      restored, learning rates are halved
//   beyond kMaxParameter
//   rays of the training views lose    training starts over with another seed
//   less than kMinOpacity of their     and half the learning rates
//   light after the warm-up
//   a step whose patches are all       nothing: the other terms go on
//   outside of every source view
//
// Each is counted. Once there are more than kMaxRestores, kMaxRestarts, or
// kMaxStepsWithoutPatch in a row that also are half of the schedule,
// std::runtime_error says what was seen and what may be changed.
class TrainingGuards {
 public:
  // Steps between snapshots: a copy of the parameters takes about as long as a
  // step.
  static constexpr int kSnapshotInterval = 200;

  static constexpr int kMaxBadSteps = 16;
  static constexpr int kMaxRestores = 10;
  static constexpr int kMaxRestarts = 3;
  static constexpr int kMaxStepsWithoutPatch = 200;

  // The largest number in half precision, in which rays read the grid.
  static constexpr float kMaxParameter = 65504.0f;

  // The field is looked at every so many shares of the training, the first
  // time after the warm-up that one share is.
  static constexpr double kOpacityInterval = 0.1;
  static constexpr double kMinOpacity = 0.01;

  TrainingGuards(const TrainingObjective& objective,
                 const ReconstructionOptions& options,
                 RenderEngine* engine);

  // Factor on all learning rates, in (0, 1].
  double LearningRateFactor() const { return learning_rate_factor_; }

  // To be called after every step, which took the schedule from `step` to
  // `next_step`, with its loss and what the update said. Returns false if the
  // engine starts over, and the steps must, too.
  bool EndStep(int step, int next_step, double loss, bool is_update_finite);

  // Starts the field over, with learning rates as they are. To be called
  // between two steps; `step` is the next one.
  void BeginAnew(int step);

  // All that later steps depend on. LoadState throws std::runtime_error if the
  // state is that of a field of another size.
  void SaveState(StateWriter* writer) const;
  void LoadState(StateReader* reader);

  // How often each guard acted, by name.
  const std::map<std::string, int>& Counts() const { return counts_; }

 private:
  void Restore(const std::string& reason);
  void CountPatches(int num_positions);
  bool IsDead(int step, int next_step) const;

  const TrainingObjective& objective_;
  const ReconstructionOptions options_;
  RenderEngine* const engine_;
  double learning_rate_factor_ = 1;
  int first_step_ = 0;  // that the field as it is has seen
  FieldParameters snapshot_;
  int num_bad_steps_ = 0;                // since the last snapshot
  int num_steps_without_patch_ = 0;      // in a row
  int num_positions_without_patch_ = 0;  // of the schedule, in these steps
  PatchCounts patch_counts_;             // up to the last step
  std::map<std::string, int> counts_;
};

}  // namespace structnerf
