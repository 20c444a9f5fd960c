#include "colmap_plugin/command_runner.h"

#include "colmap_plugin/colmap_compat.h"
#include "colmap_plugin/error_text.h"
#include "colmap_plugin/log_level.h"
#include "colmap_plugin/terminal_progress.h"
#include "nerf/util/interrupts.h"

#include <cstdlib>
#include <iostream>
#include <stdexcept>

#include <unistd.h>

namespace structnerf {
namespace {

// For work that has nothing to end early with: the first Ctrl-C aborts.
class AbortingProgress : public TerminalProgress {
 public:
  using TerminalProgress::TerminalProgress;
  bool ShouldAbort() override { return ScopedInterrupts::Count() > 0; }
};

}  // namespace

bool ParseArguments(std::vector<std::string> args,
                    colmap::OptionManager* manager) {
  std::vector<char*> argv;
  for (std::string& arg : args) {
    argv.push_back(arg.data());
  }
  return ParseOptions(static_cast<int>(argv.size()), argv.data(), manager);
}

void RequireOptions(
    const std::vector<std::pair<std::string, std::string>>& options,
    const std::string& what_to_give) {
  for (const auto& [name, value] : options) {
    if (value.empty()) {
      throw std::runtime_error("The option --" + name + " is missing; give " +
                               what_to_give + ".");
    }
  }
}

int RunReportingErrors(const std::function<int()>& command) {
  try {
    return command();
  } catch (...) {
    std::cerr << "ERROR: " << CurrentErrorText() << std::endl;
    return EXIT_FAILURE;
  }
}

void RunWithProgress(const std::function<void(RunProgress*)>& work) {
  const ScopedInterrupts interrupts;
  // COLMAP's own lines would tear the progress line apart.
  const ScopedLogLevel quiet(google::GLOG_ERROR);
  AbortingProgress progress(&std::cerr,
                            TerminalProgress::OptionsFor(STDERR_FILENO));
  try {
    work(&progress);
  } catch (const Aborted&) {
    throw std::runtime_error("Quit before the end; nothing was written.");
  }
  progress.Finish();
}

}  // namespace structnerf
