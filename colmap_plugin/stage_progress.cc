#include "colmap_plugin/stage_progress.h"

namespace structnerf {

StageProgress::StageProgress(const std::string& stage, Progress* progress)
    : stage_(stage), progress_(progress), inner_(progress) {
  Report(0, 1);
}

void StageProgress::Report(const size_t num_done, const size_t num_all) {
  ReportItems(stage_, num_done, num_all, progress_);
}

}  // namespace structnerf
