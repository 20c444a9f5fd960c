#include "ui/comparison_run.h"

#include "colmap_plugin/error_text.h"
#include "colmap_plugin/evaluation/comparison_report.h"

#include <utility>

namespace structnerf {

ComparisonRun::ComparisonRun(const ComparisonOptions& options,
                             std::string folder)
    : thread_([this, options, folder = std::move(folder)]() {
        Run(options, folder);
        has_ended_ = true;
      }) {}

ComparisonRun::~ComparisonRun() {
  progress_.Abort();
  thread_.join();
}

void ComparisonRun::Run(const ComparisonOptions& options,
                        const std::string& folder) {
  try {
    options.Check();
    page_path_ = WriteComparison(Compare(options, &progress_), folder);
  } catch (const Aborted&) {
    // Nobody waits for it any more.
  } catch (...) {
    error_ = CurrentErrorText();
  }
}

}  // namespace structnerf
