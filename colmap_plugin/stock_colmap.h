#pragma once

#include <string>
#include <vector>

namespace structnerf {

// The stock `colmap` that commands other than ours are handed to: the file in
// the environment variable COLMAP_STRUCTNERF_STOCK_COLMAP, the one beside the
// library that this was built with, or the first on PATH, never this program
// itself. Throws std::runtime_error saying what to do if there is none.
std::string FindStockColmap();

// As above with everything explicit. `environment_path` may be null and
// `search_path` is a list of folders as in PATH.
std::string FindStockColmap(const char* environment_path,
                            const std::string& configured_path,
                            const std::string& search_path,
                            const std::string& own_path);

// Replaces this process by the stock program with untouched arguments, so that
// its exit code, signals and standard streams are the caller's. Returns only on
// failure, with EXIT_FAILURE, after printing one line.
int ExecStockColmap(char** argv);

// Runs the stock program with these arguments and waits. Returns its exit code,
// -1 if it could not be run.
int RunStockColmap(const std::vector<std::string>& arguments);

}  // namespace structnerf
