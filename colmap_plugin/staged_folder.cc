#include "colmap_plugin/staged_folder.h"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <stdexcept>

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

namespace structnerf {
namespace {

namespace fs = std::filesystem;

constexpr char kFolderName[] = ".structnerf-partial";
constexpr char kLockName[] = ".lock";

[[noreturn]] void ThrowUnwritable(const std::string& path,
                                  const std::string& reason) {
  throw std::runtime_error("The folder " + path + " cannot be written (" +
                           reason +
                           "); choose another one or change its permissions.");
}

// The folders that must be created so that `path` exists, outermost first.
std::vector<std::string> MissingFolders(const fs::path& path) {
  std::vector<std::string> missing;
  for (fs::path folder = fs::absolute(path).lexically_normal();
       !fs::exists(folder) && folder.has_relative_path();
       folder = folder.parent_path()) {
    if (folder.has_filename()) {  // not the empty part after a trailing slash
      missing.insert(missing.begin(), folder.string());
    }
  }
  return missing;
}

}  // namespace

StagedFolder::StagedFolder(const std::string& output_path)
    : output_path_(output_path),
      path_((fs::path(output_path) / kFolderName).string()) {
  try {
    for (const std::string& folder : MissingFolders(output_path_)) {
      fs::create_directory(folder);
      created_parents_.push_back(folder);
    }
    fs::create_directory(path_);
    Lock();
    for (const auto& entry : fs::directory_iterator(path_)) {
      if (entry.path().filename() != kLockName) {
        fs::remove_all(entry.path());
      }
    }
  } catch (const fs::filesystem_error& error) {
    for (auto it = created_parents_.rbegin(); it != created_parents_.rend();
         ++it) {
      std::error_code ignored;
      fs::remove(*it, ignored);
    }
    ThrowUnwritable(output_path_, error.code().message());
  }
}

StagedFolder::~StagedFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
  close(lock_file_);
  if (!committed_) {
    for (auto it = created_parents_.rbegin(); it != created_parents_.rend();
         ++it) {
      fs::remove(*it, ignored);  // only while empty
    }
  }
}

void StagedFolder::Lock() {
  const std::string lock_path = (fs::path(path_) / kLockName).string();
  lock_file_ = open(lock_path.c_str(), O_CREAT | O_RDWR | O_CLOEXEC, 0644);
  if (lock_file_ < 0) {
    ThrowUnwritable(output_path_, std::strerror(errno));
  }
  if (flock(lock_file_, LOCK_EX | LOCK_NB) != 0) {
    close(lock_file_);
    throw std::runtime_error("Another run is writing to the folder " +
                             output_path_ +
                             "; wait for it to end or choose another folder.");
  }
}

void StagedFolder::Commit() {
  try {
    std::vector<fs::path> files;
    for (auto it = fs::recursive_directory_iterator(path_);
         it != fs::recursive_directory_iterator();
         ++it) {
      const fs::path target =
          fs::path(output_path_) / fs::relative(it->path(), path_);
      if (it->is_symlink() || it->path().filename() == kLockName) {
        continue;
      } else if (it->is_directory()) {
        fs::create_directories(target);
      } else {
        files.push_back(it->path());
      }
    }
    for (const fs::path& file : files) {
      fs::rename(file, fs::path(output_path_) / fs::relative(file, path_));
    }
  } catch (const fs::filesystem_error& error) {
    ThrowUnwritable(output_path_, error.code().message());
  }
  committed_ = true;
}

}  // namespace structnerf
