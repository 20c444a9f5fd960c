#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace structnerf {

// A hidden folder inside the output folder that fills up during a run. Nothing
// of the output folder is touched before Commit(), and whatever happens before
// it leaves the disk as it was, but for the hidden folder if it is kept so that
// another run can go on from there. Where the file system knows no locks, two
// runs at the same time are not noticed.
class StagedFolder {
 public:
  // What is called before anything in the output folder is looked at: puts back
  // what a run that was killed during Commit() had moved or replaced already.
  static void UndoCommit(const std::string& output_path);

  // Bytes that a run which was killed has left in the hidden folder.
  static size_t NumBytesLeft(const std::string& output_path);

  // NotesPath() of an output folder, which need not exist.
  static std::string NotesPathOf(const std::string& output_path);

  // Creates `output_path` (and its parents) if missing, and the hidden folder
  // in it. What a run that was killed has left there is removed unless
  // `resume`. Throws std::runtime_error if the folder cannot be written or
  // another run is writing there.
  StagedFolder(const std::string& output_path, bool resume);

  // Removes what this object created, unless committed or kept.
  ~StagedFolder();

  StagedFolder(const StagedFolder&) = delete;
  StagedFolder& operator=(const StagedFolder&) = delete;

  const std::string& Path() const { return path_; }

  // A folder in it for what is needed as long as the run is not complete. It is
  // not moved by Commit().
  const std::string& NotesPath() const { return notes_path_; }

  // Whether its file system has symbolic links, as those of Windows do not.
  bool CanLink() const;

  // Removes all that is in the hidden folder.
  void Clear();

  // Leaves the hidden folder for another run.
  void Keep() { kept_ = true; }

  // Moves every file into the output folder, in place of files of the same
  // name. Does not move symbolic links. Throws std::runtime_error if a file
  // cannot be moved; all are in the hidden folder then, and those that were
  // replaced are back.
  void Commit();

 private:
  void Lock();

  const std::string output_path_;
  const std::string path_;
  const std::string notes_path_;
  std::vector<std::string> created_parents_;  // outermost first
  int lock_file_ = -1;
  bool kept_ = false;
  bool committed_ = false;
};

}  // namespace structnerf
