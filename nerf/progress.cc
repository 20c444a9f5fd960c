#include "nerf/progress.h"

#include <algorithm>

namespace structnerf {

void Progress::Report(const ProgressUpdate&) {}

bool Progress::ShouldStop() { return false; }

bool Progress::ShouldAbort() { return false; }

bool Progress::ShouldSave() { return false; }

void Progress::BlockWhilePaused() {}

int Progress::PreviewViewIdx() { return -1; }

void Progress::ShowPreview(const Preview&) {}

std::chrono::steady_clock::duration PauseOrAbort(Progress* progress) {
  const auto begin = std::chrono::steady_clock::now();
  progress->BlockWhilePaused();
  if (progress->ShouldAbort()) {
    throw Aborted();
  }
  return std::chrono::steady_clock::now() - begin;
}

void ReportItems(const std::string& stage,
                 const size_t num_done,
                 const size_t num_all,
                 Progress* progress) {
  ProgressUpdate update;
  update.stage = stage;
  update.fraction =
      static_cast<double>(num_done) / std::max<size_t>(1, num_all);
  progress->Report(update);
  PauseOrAbort(progress);
}

}  // namespace structnerf
