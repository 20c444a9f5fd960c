#include "colmap_plugin/stage_progress.h"

#include <algorithm>

namespace structnerf {

StageProgress::StageProgress(const std::string& stage, Progress* progress)
    : progress_(progress), inner_(progress) {
  update_.stage = stage;
  Report(0, 1);
}

void StageProgress::Report(const size_t num_done, const size_t num_all) {
  update_.fraction =
      static_cast<double>(num_done) / std::max<size_t>(1, num_all);
  progress_->Report(update_);
  PauseOrAbort(progress_);
}

}  // namespace structnerf
