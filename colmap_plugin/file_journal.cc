#include "colmap_plugin/file_journal.h"

#include "nerf/util/checksummed_file.h"

#include <filesystem>
#include <fstream>
#include <ios>
#include <sstream>
#include <stdexcept>
#include <utility>
#include <vector>

namespace structnerf {
namespace {

namespace fs = std::filesystem;

constexpr char kHead[] = "structnerf journal 1 ";
constexpr size_t kBlockSize = size_t{1} << 20;

// Size and checksum of a file; false if it cannot be read.
bool Measure(const std::string& path, uint64_t* num_bytes, uint64_t* checksum) {
  std::ifstream file(path, std::ios::binary);
  std::vector<char> block(kBlockSize);
  Checksum sum;
  *num_bytes = 0;
  while (file) {
    file.read(block.data(), static_cast<std::streamsize>(block.size()));
    sum.Add(block.data(), static_cast<size_t>(file.gcount()));
    *num_bytes += static_cast<uint64_t>(file.gcount());
  }
  *checksum = sum.Value();
  return file.eof();
}

}  // namespace

bool FileJournal::Exists(const std::string& path, const std::string& key) {
  std::ifstream file(path, std::ios::binary);
  std::string line;
  return std::getline(file, line) && !file.eof() && line == kHead + key;
}

FileJournal::FileJournal(std::string path,
                         std::string folder,
                         const std::string& key)
    : path_(std::move(path)), folder_(std::move(folder)) {
  if (!Exists(path_, key)) {
    std::ofstream(path_, std::ios::binary | std::ios::trunc);
    Append(kHead + key);
    return;
  }
  std::ifstream file(path_, std::ios::binary);
  std::string line;
  std::getline(file, line);
  // What comes after the last end of line was torn.
  while (std::getline(file, line) && !file.eof()) {
    std::istringstream stream(line);
    Entry entry;
    std::string name;
    if (stream >> std::hex >> entry.checksum >> std::dec >> entry.num_bytes &&
        stream.get() == ' ' && std::getline(stream, name)) {
      entries_[name] = entry;
    }
  }
  if (!line.empty()) {
    Append("");
  }
}

bool FileJournal::IsIntact(const std::string& file_path) const {
  const auto it = entries_.find(Name(file_path));
  Entry found;
  return it != entries_.end() &&
         Measure(file_path, &found.num_bytes, &found.checksum) &&
         found.num_bytes == it->second.num_bytes &&
         found.checksum == it->second.checksum;
}

void FileJournal::Add(const std::string& file_path) {
  Entry entry;
  if (!Measure(file_path, &entry.num_bytes, &entry.checksum)) {
    throw std::runtime_error("The file " + file_path +
                             " could not be read back.");
  }
  std::ostringstream line;
  line << std::hex << entry.checksum << " " << std::dec << entry.num_bytes
       << " " << Name(file_path);
  Append(line.str());
  entries_[Name(file_path)] = entry;
}

std::string FileJournal::Name(const std::string& file_path) const {
  return fs::path(file_path).lexically_relative(folder_).string();
}

void FileJournal::Append(const std::string& line) {
  std::ofstream file(path_, std::ios::binary | std::ios::app);
  file << line << "\n";
  file.close();
  if (!file) {
    throw std::runtime_error("The file " + path_ +
                             " could not be written; is the disk full?");
  }
}

}  // namespace structnerf
