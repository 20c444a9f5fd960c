#pragma once

#include "nerf/checkpoint_options.h"
#include "nerf/engine/render_engine.h"
#include "nerf/reconstructor.h"
#include "nerf/scene.h"
#include "nerf/train/convergence.h"
#include "nerf/train/matched_depth.h"
#include "nerf/train/training_guards.h"

#include <chrono>
#include <limits>
#include <memory>

namespace structnerf {

// What training knows between two steps besides the engine and the guards.
struct TrainingState {
  TrainingSummary summary;  // the parts that add up step by step
  int step = 0;             // the next one
  bool is_complete = false;
  double mean_loss = std::numeric_limits<double>::quiet_NaN();  // NaN = none
  double held_out_psnr = -1;
  double next_psnr = 0;  // share of the training at which it is measured next
  ConvergenceMonitor convergence;

  // Of the second round, if there is one and it has begun: what it learns from,
  // and the field of the first round, until the new one is better.
  std::shared_ptr<const MatchedDepth> matched_depth;
  FieldParameters first_round;
};

// The checkpoints of one training. Learning rates, level weights and the rays
// that are drawn follow from options and step, so that training goes on from a
// checkpoint as if it had not been interrupted, to the last bit; on a graphics
// card, up to rounding.
//
// Two are kept, because the newest can be damaged. A file has the run it
// belongs to, the states of training, guards and engine, and a checksum over
// all of it (nerf/util/checksummed_file.h).
class Checkpoints {
 public:
  // `scene` becomes a part of what the run is told from others by.
  Checkpoints(const CheckpointOptions& options, const Scene& scene);

  bool IsEnabled() const { return !options_.folder.empty(); }

  // Loads the newest intact checkpoint. Returns false, and leaves everything
  // alone, if there is none. Throws CheckpointMismatch if it is one of another
  // run.
  bool Load(RenderEngine* engine,
            TrainingGuards* guards,
            TrainingState* state) const;

  // Throws std::runtime_error if it cannot be written; the older ones are
  // there then as before.
  void Save(const RenderEngine& engine,
            const TrainingGuards& guards,
            const TrainingState& state);

  // Saves if the last time is long enough ago.
  void SaveIfDue(const RenderEngine& engine,
                 const TrainingGuards& guards,
                 const TrainingState& state);

 private:
  CheckpointOptions options_;
  std::chrono::steady_clock::time_point last_save_;
};

}  // namespace structnerf
