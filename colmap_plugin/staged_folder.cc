#include "colmap_plugin/staged_folder.h"

#include "nerf/util/image_name.h"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <set>
#include <stdexcept>

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

namespace structnerf {
namespace {

namespace fs = std::filesystem;

constexpr char kFolderName[] = ".structnerf-partial";
constexpr char kNotesName[] = ".resume";
constexpr char kLockName[] = ".lock";

// Lists the files that are being moved, while they are, and the folders that
// are made for them, which end in a slash.
constexpr char kCommitName[] = "commit";

// Holds what they replace, until all are moved.
constexpr char kReplacedName[] = "replaced";

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

void RemoveFolders(const std::vector<std::string>& folders) {
  std::error_code ignored;
  for (auto it = folders.rbegin(); it != folders.rend(); ++it) {
    fs::remove(*it, ignored);  // only while empty
  }
}

// A file that is locked until it is closed; -1 if it cannot be created, -2 if
// another process has locked it. File systems of clusters may know no locks;
// then there is none.
int OpenLocked(const std::string& path) {
  const int file = open(path.c_str(), O_CREAT | O_RDWR | O_CLOEXEC, 0644);
  if (file >= 0 && flock(file, LOCK_EX | LOCK_NB) != 0 &&
      errno == EWOULDBLOCK) {
    close(file);
    return -2;
  }
  return file;
}

// Relative paths of the files to move.
std::vector<std::string> ListFiles(const fs::path& folder) {
  std::vector<std::string> files;
  for (auto it = fs::recursive_directory_iterator(folder);
       it != fs::recursive_directory_iterator();
       ++it) {
    if (it->path().filename() == kNotesName) {
      it.disable_recursion_pending();
    } else if (!it->is_symlink() && !it->is_directory() &&
               it->path().filename() != kLockName) {
      files.push_back(it->path().lexically_relative(folder).string());
    }
  }
  return files;
}

// The folders that must be made in `folder` for these files, outermost first.
std::set<std::string> FoldersToMake(const fs::path& folder,
                                    const std::vector<std::string>& files) {
  std::set<std::string> missing;
  for (const std::string& file : files) {
    for (fs::path parent = fs::path(file).parent_path();
         !parent.empty() && !fs::exists(folder / parent);
         parent = parent.parent_path()) {
      missing.insert(parent.string());
    }
  }
  return missing;
}

void WriteList(const std::string& path,
               const std::vector<std::string>& files,
               const std::set<std::string>& folders) {
  std::ofstream stream(path + ".partial", std::ios::binary);
  for (const std::string& file : files) {
    stream << file << '\0';
  }
  for (const std::string& folder : folders) {
    stream << folder << "/" << '\0';
  }
  stream.close();
  if (!stream) {
    ThrowUnwritable(path, "is the disk full?");
  }
  fs::rename(path + ".partial", path);
}

// Also if there is only a link that leads nowhere.
bool IsTaken(const fs::path& path) {
  return fs::exists(fs::symlink_status(path));
}

void MoveFile(const fs::path& from, const fs::path& to) {
  fs::create_directories(to.parent_path());
  fs::rename(from, to);
}

void MoveBack(const fs::path& output_path, const fs::path& path) {
  const fs::path list_path = path / kNotesName / kCommitName;
  const fs::path replaced_path = path / kNotesName / kReplacedName;
  std::ifstream list(list_path, std::ios::binary);
  std::vector<std::string> folders;
  for (std::string file; std::getline(list, file, '\0');) {
    const bool is_folder = !file.empty() && file.back() == '/';
    if (is_folder) {
      file.pop_back();
    }
    if (!IsSafeImageName(file)) {
      continue;  // no list of ours: it must not lead out of the folder
    }
    if (is_folder) {
      // An empty one looks like a workspace.
      folders.push_back((output_path / file).string());
      continue;
    }
    if (!fs::exists(path / file) && fs::exists(output_path / file)) {
      MoveFile(output_path / file, path / file);
    }
    if (IsTaken(replaced_path / file) && !IsTaken(output_path / file)) {
      MoveFile(replaced_path / file, output_path / file);
    }
  }
  RemoveFolders(folders);
  fs::remove(list_path);
}

}  // namespace

void StagedFolder::UndoCommit(const std::string& output_path) {
  const fs::path path = fs::path(output_path) / kFolderName;
  std::error_code error;
  if (!fs::exists(path / kNotesName / kCommitName, error)) {
    return;
  }
  const int lock_file = OpenLocked((path / kLockName).string());
  if (lock_file < 0) {
    return;  // the constructor says why
  }
  try {
    MoveBack(output_path, path);
  } catch (const fs::filesystem_error& filesystem_error) {
    close(lock_file);
    ThrowUnwritable(output_path, filesystem_error.code().message());
  }
  close(lock_file);
}

std::string StagedFolder::NotesPathOf(const std::string& output_path) {
  return (fs::path(output_path) / kFolderName / kNotesName).string();
}

size_t StagedFolder::NumBytesLeft(const std::string& output_path) {
  size_t num_bytes = 0;
  std::error_code error;
  for (auto it = fs::recursive_directory_iterator(
           fs::path(output_path) / kFolderName, error);
       !error && it != fs::recursive_directory_iterator();
       it.increment(error)) {
    std::error_code file_error;
    const size_t size = it->is_symlink(file_error) ? 0
                        : it->is_regular_file(file_error)
                            ? it->file_size(file_error)
                            : 0;
    num_bytes += file_error ? 0 : size;
  }
  return num_bytes;
}

StagedFolder::StagedFolder(const std::string& output_path, const bool resume)
    : output_path_(output_path),
      path_((fs::path(output_path) / kFolderName).string()),
      notes_path_(NotesPathOf(output_path)) {
  try {
    for (const std::string& folder : MissingFolders(output_path_)) {
      fs::create_directory(folder);
      created_parents_.push_back(folder);
    }
    fs::create_directory(path_);
    Lock();
    if (!resume) {
      Clear();
    }
    fs::create_directory(notes_path_);
  } catch (const fs::filesystem_error& error) {
    if (lock_file_ >= 0) {
      close(lock_file_);
    }
    RemoveFolders(created_parents_);
    ThrowUnwritable(output_path_, error.code().message());
  }
}

StagedFolder::~StagedFolder() {
  if (!kept_) {
    // The notes first: without them, what else is left cannot be mistaken.
    std::error_code ignored;
    fs::remove_all(notes_path_, ignored);
    fs::remove_all(path_, ignored);
  }
  close(lock_file_);
  if (!committed_ && !kept_) {
    RemoveFolders(created_parents_);
  }
}

bool StagedFolder::CanLink() const {
  const fs::path link = fs::path(notes_path_) / "link";
  std::error_code error;
  fs::create_directory_symlink(path_, link, error);
  std::error_code ignored;
  fs::remove(link, ignored);
  return !error;
}

void StagedFolder::Clear() {
  for (const auto& entry : fs::directory_iterator(path_)) {
    if (entry.path().filename() != kLockName) {
      fs::remove_all(entry.path());
    }
  }
  fs::create_directory(notes_path_);
}

void StagedFolder::Lock() {
  lock_file_ = OpenLocked((fs::path(path_) / kLockName).string());
  if (lock_file_ == -1) {
    ThrowUnwritable(output_path_, std::strerror(errno));
  }
  if (lock_file_ == -2) {
    throw std::runtime_error("Another run is writing to the folder " +
                             output_path_ +
                             "; wait for it to end or choose another folder.");
  }
}

void StagedFolder::Commit() {
  const std::string list_path = (fs::path(notes_path_) / kCommitName).string();
  const fs::path replaced_path = fs::path(notes_path_) / kReplacedName;
  try {
    const std::vector<std::string> files = ListFiles(path_);
    fs::remove_all(replaced_path);
    WriteList(list_path, files, FoldersToMake(output_path_, files));
    for (const std::string& file : files) {
      const fs::path target = fs::path(output_path_) / file;
      // A folder in the way is no result that could be replaced.
      if (IsTaken(target) && !fs::is_directory(fs::symlink_status(target))) {
        MoveFile(target, replaced_path / file);
      }
      MoveFile(fs::path(path_) / file, target);
    }
    fs::remove(list_path);
  } catch (const fs::filesystem_error& error) {
    // What cannot be moved back now must not be removed: the next run tries.
    const bool is_kept = kept_;
    kept_ = true;
    MoveBack(output_path_, path_);
    kept_ = is_kept;
    ThrowUnwritable(output_path_, error.code().message());
  }
  committed_ = true;
}

}  // namespace structnerf
