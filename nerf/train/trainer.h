#pragma once

#include "nerf/engine/render_engine.h"
#include "nerf/extract/preview_renderer.h"
#include "nerf/options.h"
#include "nerf/progress.h"
#include "nerf/reconstructor.h"
#include "nerf/scene.h"
#include "nerf/scene_frame.h"
#include "nerf/train/checkpoint.h"
#include "nerf/train/training_objective.h"
#include "nerf/view_selection.h"

#include <vector>

namespace structnerf {

// Runs the training loop on an engine.
class Trainer {
 public:
  // `test_view_idxs`: views that were held out, for PSNR. Without any, it is
  // measured at the pixels that the objective holds out of all views.
  Trainer(const TrainingObjective& objective,
          const std::vector<int>& test_view_idxs,
          const ReconstructionOptions& options,
          RenderEngine* engine);

  // Throws Aborted if told to abort. Time in which it is paused does not count.
  // `previews` serves those who watch; null = nobody does. The schedule is
  // fitted into `max_seconds` from now on, if positive
  // (nerf/train/training_schedule.h).
  TrainingSummary Run(Progress* progress,
                      PreviewRenderer* previews,
                      Checkpoints* checkpoints,
                      double max_seconds = 0);

 private:
  StepParameters MakeStep(int step) const;

  struct TestPixel {
    int view_idx = -1;
    int col = 0;
    int row = 0;
  };

  void ChooseTestPixels(const std::vector<int>& test_view_idxs);

  // What is rendered at the test pixels.
  struct Measurement {
    double squared_error = 0;  // mean over pixels and channels
    std::vector<float> depths;

    double Psnr() const;  // -1 without test pixels
  };
  Measurement MeasureTestPixels() const;

  const TrainingObjective& objective_;
  const ReconstructionOptions options_;
  const std::vector<Appearance> appearances_;  // of each view
  std::vector<TestPixel> test_pixels_;
  RenderEngine* const engine_;
};

}  // namespace structnerf
