#include "nerf/progress.h"

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

}  // namespace structnerf
