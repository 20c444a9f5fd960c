#pragma once

#include "nerf/engine/render_engine.h"
#include "nerf/extract/preview_renderer.h"
#include "nerf/options.h"
#include "nerf/progress.h"
#include "nerf/reconstructor.h"
#include "nerf/scene.h"
#include "nerf/scene_frame.h"
#include "nerf/train/checkpoint.h"
#include "nerf/train/matched_depth.h"
#include "nerf/train/training_objective.h"
#include "nerf/view_selection.h"

#include <vector>

namespace structnerf {

// Runs the training loop on an engine.
class Trainer {
 public:
  // `test_view_idxs`: views that were held out, for PSNR. Without any, it is
  // measured at the pixels that the objective holds out of all views.
  // `match_views`: if there is one, training has two rounds. After the first
  // one, which is LossOptions::match_fraction of the training, views are
  // matched, and the field begins anew and learns from that, too: one that goes
  // on keeps what it has wrong. Learning rates fall, and levels come in, in
  // both.
  Trainer(TrainingObjective* objective,
          const std::vector<int>& test_view_idxs,
          const ReconstructionOptions& options,
          RenderEngine* engine,
          MatchFunction match_views = nullptr);

  // Throws Aborted if told to abort. Time in which it is paused, or views are
  // matched, does not count.
  // `previews` serves those who watch; null = nobody does. The schedule is
  // fitted into `max_seconds` from now on, if positive
  // (nerf/train/training_schedule.h).
  TrainingSummary Run(Progress* progress,
                      PreviewRenderer* previews,
                      Checkpoints* checkpoints,
                      double max_seconds = 0);

 private:
  // Share of its round of which a step is the beginning.
  double ShareOfRound(int step) const;

  StepParameters MakeStep(int step) const;
  bool WaitsForMatches(const TrainingState& state) const;

  // Whether all levels of the field have come in, in this round.
  bool HasAllLevels(int step) const;

  // What is between the rounds.
  void MatchViews(Progress* progress,
                  TrainingGuards* guards,
                  TrainingState* state);

  void ForgetMatches(TrainingState* state);

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

  TrainingObjective& objective_;
  const ReconstructionOptions options_;
  const std::vector<Appearance> appearances_;  // of each view
  std::vector<TestPixel> test_pixels_;
  RenderEngine* const engine_;
  const MatchFunction match_views_;
  const int second_round_;  // its first step; 0 = there is only one round
};

}  // namespace structnerf
