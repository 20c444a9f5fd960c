#include "ui/dense_run.h"

#include <utility>

namespace structnerf {

DenseRun::DenseRun(const StructNerfOptions& options,
                   std::shared_ptr<const colmap::Reconstruction> reconstruction)
    : controller_(std::make_unique<StructNerfController>(
          options, std::move(reconstruction), &progress_)),
      thread_([this]() {
        controller_->Run();
        has_ended_ = true;
      }) {}

DenseRun::~DenseRun() {
  progress_.Abort();
  thread_.join();
}

}  // namespace structnerf
