#pragma once

#include "colmap_plugin/structnerf_controller.h"
#include "ui/gui_progress.h"

#include <atomic>
#include <memory>
#include <string>
#include <thread>

namespace structnerf {

// A run of the dense stage on a thread of its own, on a copy of the model.
class DenseRun {
 public:
  // Starts it.
  DenseRun(const StructNerfOptions& options,
           std::shared_ptr<const colmap::Reconstruction> reconstruction);

  // Aborts it if it has not ended, which takes less than a second.
  ~DenseRun();

  DenseRun(const DenseRun&) = delete;
  DenseRun& operator=(const DenseRun&) = delete;

  GuiProgress& Progress() { return progress_; }

  bool HasEnded() const { return has_ended_; }

  // Once it has ended.
  StructNerfController::Status Status() const {
    return controller_->GetStatus();
  }
  const std::string& Error() const { return controller_->Error(); }
  const std::string& KeptPath() const { return controller_->KeptPath(); }
  const RunReport& Report() const { return controller_->Report(); }

 private:
  GuiProgress progress_;
  std::unique_ptr<StructNerfController> controller_;
  std::atomic<bool> has_ended_ = false;
  std::thread thread_;
};

}  // namespace structnerf
