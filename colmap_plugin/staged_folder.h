#pragma once

#include <string>
#include <vector>

namespace structnerf {

// A hidden folder inside the output folder that fills up during a run. Nothing
// of the output folder is touched before Commit(), and whatever happens before
// it leaves the disk as it was.
class StagedFolder {
 public:
  // Creates `output_path` (and its parents) if missing, and the hidden folder
  // in it; one that a killed run left behind is replaced. Throws
  // std::runtime_error if the folder cannot be written or another run is
  // writing there.
  explicit StagedFolder(const std::string& output_path);

  // Removes what this object created, unless committed.
  ~StagedFolder();

  StagedFolder(const StagedFolder&) = delete;
  StagedFolder& operator=(const StagedFolder&) = delete;

  const std::string& Path() const { return path_; }

  // Moves every file into the output folder, over files of the same name. Does
  // not move symbolic links. Throws std::runtime_error if a file cannot be
  // moved.
  void Commit();

 private:
  void Lock();

  const std::string output_path_;
  const std::string path_;
  std::vector<std::string> created_parents_;  // outermost first
  int lock_file_ = -1;
  bool committed_ = false;
};

}  // namespace structnerf
