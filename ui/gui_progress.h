#pragma once

#include "colmap_plugin/run_progress.h"

#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

namespace structnerf {

// How often windows look at what is going on.
constexpr int kPollMilliseconds = 100;

// One measurement of the training.
struct CurvePoint {
  double fraction = 0;  // of the training, in [0, 1]
  double value = 0;
};

// What a window can show of a run.
struct RunState {
  std::string stage;
  double fraction = 0;       // of the stage
  double seconds_left = -1;  // of the stage; -1 = not known yet
  bool is_paused = false;
  bool is_stopping = false;  // told to end in one of the ways there are
  std::vector<CurvePoint> loss;
  std::vector<CurvePoint> held_out_psnr;   // dB
  std::shared_ptr<const Preview> preview;  // the latest; null = none yet
};

// Carries wishes of the user to a run and news of the run to the user. The run
// uses it from its own thread, the window from that of the user interface;
// neither waits for the other, except that a run waits while it is paused.
class GuiProgress : public RunProgress {
 public:
  // Of the run.
  void Report(const ProgressUpdate& update) override;
  bool ShouldStop() override;
  bool ShouldAbort() override;
  bool ShouldSave() override;
  void BlockWhilePaused() override;
  void ShowPreview(const Preview& preview) override;
  std::string PreviewImage() override;

  // Of the window.
  void SetPaused(bool is_paused);
  void Stop();                               // keep what has been learned
  void Abort();                              // keep nothing
  void Suspend();                            // keep what can be gone on with
  void WatchImage(const std::string& name);  // empty = none
  RunState State() const;

 private:
  using Clock = std::chrono::steady_clock;

  mutable std::mutex mutex_;
  std::condition_variable resumed_;
  RunState state_;
  bool should_stop_ = false;
  bool should_abort_ = false;
  bool should_save_ = false;
  std::string preview_image_;
  Clock::time_point stage_begin_ = Clock::now();
};

}  // namespace structnerf
