#pragma once

#include "colmap_plugin/run_progress.h"

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include <colmap/controllers/option_manager.h>

namespace structnerf {

// Parses `args`, which ExpandCommandLine has seen, into what `manager` was told
// of. Returns false if the command line is wrong, which has been said then.
bool ParseArguments(std::vector<std::string> args,
                    colmap::OptionManager* manager);

// Throws std::runtime_error about the first option of these (name, value) that
// was not given, and says what to give.
void RequireOptions(
    const std::vector<std::pair<std::string, std::string>>& options,
    const std::string& what_to_give);

// Runs a command to its end: what it throws becomes one line on standard error
// and EXIT_FAILURE.
int RunReportingErrors(const std::function<int()>& command);

// Runs long work with its progress on standard error, which Ctrl-C aborts.
// Throws std::runtime_error if it was.
void RunWithProgress(const std::function<void(RunProgress*)>& work);

}  // namespace structnerf
