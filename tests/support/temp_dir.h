#pragma once

#include <atomic>
#include <filesystem>
#include <random>
#include <string>
#include <system_error>

namespace structnerf {

// A new empty folder in the system's folder for temporary files. It is removed
// with all its contents at the end of the object's life.
class TempDir {
 public:
  TempDir() {
    static std::atomic<unsigned> counter{0};
    std::random_device random;
    const std::filesystem::path parent = std::filesystem::temp_directory_path();
    do {
      path_ = parent / ("structnerf_" + std::to_string(random()) + "_" +
                        std::to_string(counter++));
    } while (!std::filesystem::create_directory(path_));
  }

  ~TempDir() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }

  TempDir(const TempDir&) = delete;
  TempDir& operator=(const TempDir&) = delete;

  const std::filesystem::path& Path() const { return path_; }

  // Path of a file or folder below this one.
  std::string operator/(const std::string& name) const {
    return (path_ / name).string();
  }

 private:
  std::filesystem::path path_;
};

}  // namespace structnerf
