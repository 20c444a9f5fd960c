#pragma once

#include "nerf/train/trainer.h"
#include "tests/nerf/fake_engine.h"
#include "tests/nerf/plane_scene.h"

#include <algorithm>
#include <chrono>
#include <limits>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

namespace structnerf {

// Writes down what it is told, and can stop or abort at a step.
class RecordingProgress : public Progress {
 public:
  void Report(const ProgressUpdate& update) override {
    updates.push_back(update);
  }
  bool ShouldStop() override { return num_stop_asked++ >= stop_at; }
  bool ShouldAbort() override { return num_abort_asked++ >= abort_at; }
  void BlockWhilePaused() override { std::this_thread::sleep_for(pause); }
  bool ShouldSave() override { return should_save; }

  std::vector<ProgressUpdate> updates;
  int num_stop_asked = 0;
  int num_abort_asked = 0;
  int stop_at = std::numeric_limits<int>::max();
  int abort_at = std::numeric_limits<int>::max();
  std::chrono::milliseconds pause{0};  // before each step
  bool should_save = false;
};

class TrainerTest : public testing::Test {
 protected:
  TrainerTest() {
    for (int v = 0; v < 3; ++v) {
      scene_.views.push_back(
          MakeView("view", MakeCamera(16, 12, 12), {0.2 * v, 0, 0}));
      scene_.views.back().image = PlainImage(16, 12, 128);
    }
    scene_.points = {MakePoint(scene_, {0, 0, 4}, {0, 1, 2})};
    options_.training.num_steps = 200;
    options_.training.rays_per_step = 64;
  }

  TrainingSummary Run(const std::vector<int>& test_view_idxs = {}) {
    const SceneFrame frame = ComputeSceneFrame(scene_);
    std::vector<int> train_view_idxs;
    for (int v = 0; v < 3; ++v) {
      if (std::count(test_view_idxs.begin(), test_view_idxs.end(), v) == 0) {
        train_view_idxs.push_back(v);
      }
    }
    TrainingObjective objective(scene_,
                                frame,
                                train_view_idxs,
                                {{}, {}, {}},
                                options_.loss,
                                options_.training);
    Checkpoints checkpoints(checkpoint_options_, scene_);
    return Trainer(&objective, test_view_idxs, options_, &engine_, match_views_)
        .Run(&progress_, /*previews=*/nullptr, &checkpoints);
  }

  Scene scene_;
  ReconstructionOptions options_;
  CheckpointOptions checkpoint_options_;
  FakeEngine engine_;
  RecordingProgress progress_;
  MatchFunction match_views_;
};

}  // namespace structnerf
