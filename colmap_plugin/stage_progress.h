#pragma once

#include "nerf/progress.h"

#include <cstddef>
#include <string>

namespace structnerf {

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

// One stage of long work that goes over items: tells how far it is, and ends it
// when told to.
class StageProgress {
 public:
  // `progress` must outlive this object. Throws Aborted if told to.
  StageProgress(const std::string& stage, Progress* progress);

  // To be called after each item. Throws Aborted if told to.
  void Report(size_t num_done, size_t num_all);

  // For work inside of an item.
  Progress* Inner() { return &inner_; }

 private:
  ProgressUpdate update_;
  Progress* progress_;
  SilentProgress inner_;
};

}  // namespace structnerf
