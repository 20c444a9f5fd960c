#pragma once

#include <cstdint>
#include <map>
#include <string>

namespace structnerf {

// Which files of a folder are complete, with their checksums, so that a run
// that goes on after it was killed knows what need not be made again. One line
// per file, appended when the file is done; a line that was torn counts as
// none.
class FileJournal {
 public:
  // Whether there is a journal of this key.
  static bool Exists(const std::string& path, const std::string& key);

  // Reads the journal at `path` about files below `folder`. One of another
  // `key`, which stands for what the files are made from, is emptied.
  FileJournal(std::string path, std::string folder, const std::string& key);

  // Whether the file is there as it was added.
  bool IsIntact(const std::string& file_path) const;

  // Throws std::runtime_error, naming the file, if it cannot be read, or the
  // journal not be written.
  void Add(const std::string& file_path);

 private:
  struct Entry {
    uint64_t num_bytes = 0;
    uint64_t checksum = 0;
  };

  // Relative to the folder, which may have been moved.
  std::string Name(const std::string& file_path) const;
  void Append(const std::string& line);

  const std::string path_;
  const std::string folder_;
  std::map<std::string, Entry> entries_;
};

}  // namespace structnerf
