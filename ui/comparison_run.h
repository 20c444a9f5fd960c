#pragma once

#include "colmap_plugin/evaluation/comparison.h"
#include "ui/gui_progress.h"

#include <atomic>
#include <string>
#include <thread>

namespace structnerf {

// A comparison of two workspaces on a thread of its own.
class ComparisonRun {
 public:
  // Starts it. Its page is written into `folder`.
  ComparisonRun(const ComparisonOptions& options, std::string folder);

  // Aborts it if it has not ended.
  ~ComparisonRun();

  ComparisonRun(const ComparisonRun&) = delete;
  ComparisonRun& operator=(const ComparisonRun&) = delete;

  GuiProgress& Progress() { return progress_; }

  bool HasEnded() const { return has_ended_; }

  // Once it has ended: of the page, or empty if it failed or was aborted.
  const std::string& PagePath() const { return page_path_; }

  // Why it failed, in a sentence; else empty.
  const std::string& Error() const { return error_; }

 private:
  void Run(const ComparisonOptions& options, const std::string& folder);

  GuiProgress progress_;
  std::string page_path_;
  std::string error_;
  std::atomic<bool> has_ended_ = false;
  std::thread thread_;
};

}  // namespace structnerf
