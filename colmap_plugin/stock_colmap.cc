#include "colmap_plugin/stock_colmap.h"

#include "colmap_plugin/child_process.h"

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <iostream>
#include <sstream>
#include <stdexcept>

#include <unistd.h>

namespace structnerf {
namespace {

namespace fs = std::filesystem;

constexpr char kEnvironmentVariable[] = "COLMAP_STRUCTNERF_STOCK_COLMAP";

bool IsProgram(const std::string& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored) && access(path.c_str(), X_OK) == 0;
}

// Follows symbolic links, since we are also installed as `colmap`.
bool IsSameFile(const std::string& path1, const std::string& path2) {
  std::error_code error;
  return fs::equivalent(path1, path2, error) && !error;
}

}  // namespace

std::string FindStockColmap() {
  const char* search_path = std::getenv("PATH");
  return FindStockColmap(std::getenv(kEnvironmentVariable),
                         STRUCTNERF_STOCK_COLMAP,
                         search_path != nullptr ? search_path : "",
                         "/proc/self/exe");
}

std::string FindStockColmap(const char* environment_path,
                            const std::string& configured_path,
                            const std::string& search_path,
                            const std::string& own_path) {
  if (environment_path != nullptr && environment_path[0] != '\0') {
    if (!IsProgram(environment_path) ||
        IsSameFile(environment_path, own_path)) {
      throw std::runtime_error(std::string("The file ") + environment_path +
                               " named by " + kEnvironmentVariable +
                               " is not a stock colmap program.");
    }
    return environment_path;
  }
  if (IsProgram(configured_path) && !IsSameFile(configured_path, own_path)) {
    return configured_path;
  }
  std::istringstream folders(search_path);
  std::string folder;
  while (std::getline(folders, folder, ':')) {
    // An empty entry of PATH is the current folder.
    const std::string path =
        (fs::path(folder.empty() ? "." : folder) / "colmap").string();
    if (IsProgram(path) && !IsSameFile(path, own_path)) {
      return path;
    }
  }
  throw std::runtime_error(
      std::string("No stock colmap was found for this command; install COLMAP "
                  "or set ") +
      kEnvironmentVariable + " to its program.");
}

int ExecStockColmap(char** argv) {
  try {
    const std::string path = FindStockColmap();
    execv(path.c_str(), argv);
    std::cerr << "ERROR: " << path << " cannot be run: " << std::strerror(errno)
              << "." << std::endl;
  } catch (const std::exception& error) {
    std::cerr << "ERROR: " << error.what() << std::endl;
  }
  return EXIT_FAILURE;
}

int RunStockColmap(const std::vector<std::string>& arguments) {
  return RunChildProcess(FindStockColmap(), arguments, /*keep_output=*/true);
}

}  // namespace structnerf
