#pragma once

#include "nerf/preview.h"

#include <chrono>
#include <cstddef>
#include <limits>
#include <string>

namespace structnerf {

// What long work tells the one who waits for it.
struct ProgressUpdate {
  std::string stage;         // e.g. "Training"
  double fraction = 0;       // of this stage, in [0, 1]
  double seconds_left = -1;  // of this stage; -1 = not known yet

  // Total training loss, of either sign; NaN = none.
  double loss = std::numeric_limits<double>::quiet_NaN();
  double held_out_psnr = -1;  // dB; -1 = none
};

// Passed down into long work. The default implementation is silent, never stops
// or pauses, and asks for no preview. All functions are called from the thread
// that runs the work.
class Progress {
 public:
  virtual ~Progress() = default;

  virtual void Report(const ProgressUpdate& update);

  // Polled at least every 200 ms; where the field is NeRF's own networks, every
  // training step or batch of rays, which take seconds to minutes there; while
  // views are matched in the midst of training, once per view. Once true,
  // training ends with what it has learned and later stages still run, unless
  // ShouldAbort() is true as well.
  virtual bool ShouldStop();

  // Polled at least every 200 ms or batch of rays. Once true, the work ends as
  // soon as possible by throwing Aborted.
  virtual bool ShouldAbort();

  // Asked of work that aborts: whether it shall save what it has done, if it
  // can go on from there another time.
  virtual bool ShouldSave();

  // Called as often; returns when the work may go on.
  virtual void BlockWhilePaused();

  // The view that somebody wants to watch during training, -1 = none. Asked
  // between steps.
  virtual int PreviewViewIdx();

  // That view, at most so often that rendering it costs few percent of the
  // training.
  virtual void ShowPreview(const Preview& preview);
};

// For work on one item of many, whose own fractions would only confuse.
class SilentProgress : public Progress {
 public:
  explicit SilentProgress(Progress* progress) : progress_(progress) {}
  bool ShouldStop() override { return progress_->ShouldStop(); }
  bool ShouldAbort() override { return progress_->ShouldAbort(); }
  void BlockWhilePaused() override { progress_->BlockWhilePaused(); }

 private:
  Progress* progress_;
};

// Thrown by work that was told to abort.
struct Aborted {};

// To be called between pieces of work: waits while it is paused and throws
// Aborted if it was told to abort. Returns the time spent waiting.
std::chrono::steady_clock::duration PauseOrAbort(Progress* progress);

// To be called after each of `num_all` items that a stage goes over: tells how
// far it is, and does what PauseOrAbort does.
void ReportItems(const std::string& stage,
                 size_t num_done,
                 size_t num_all,
                 Progress* progress);

}  // namespace structnerf
