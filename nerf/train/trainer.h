#pragma once

#include "nerf/engine/render_engine.h"
#include "nerf/options.h"
#include "nerf/progress.h"
#include "nerf/reconstructor.h"
#include "nerf/scene.h"
#include "nerf/scene_frame.h"
#include "nerf/train/training_objective.h"

#include <vector>

namespace structnerf {

// Runs the training loop on an engine.
class Trainer {
 public:
  // `test_view_idxs`: views that were held out, for PSNR.
  Trainer(const TrainingObjective& objective,
          const std::vector<int>& test_view_idxs,
          const ReconstructionOptions& options,
          RenderEngine* engine);

  // Throws Aborted if told to abort.
  TrainingSummary Run(Progress* progress);

 private:
  StepParameters MakeStep(int step) const;

  // PSNR over a fixed choice of the unmasked pixels of the held-out views; -1
  // without any.
  double HeldOutPsnr() const;

  const TrainingObjective& objective_;
  const std::vector<int> test_view_idxs_;
  const ReconstructionOptions options_;
  RenderEngine* const engine_;
};

}  // namespace structnerf
