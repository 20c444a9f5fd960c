#include "colmap_plugin/run_progress.h"

#include <glog/logging.h>

namespace structnerf {

void RunProgress::Note(const std::string& sentence) { LOG(INFO) << sentence; }

void RunProgress::Warn(const std::string& sentence) {
  LOG(WARNING) << sentence;
}

std::string RunProgress::PreviewImage() { return ""; }

}  // namespace structnerf
