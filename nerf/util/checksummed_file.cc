#include "nerf/util/checksummed_file.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <vector>

#include <fcntl.h>
#include <unistd.h>

namespace structnerf {
namespace {

namespace fs = std::filesystem;

constexpr uint64_t kPrime = 1099511628211ULL;
constexpr size_t kHeadSize = sizeof(FileFormat::magic) + sizeof(uint32_t);
constexpr size_t kBlockSize = size_t{1} << 16;

uint64_t AddWord(const uint64_t hash, const unsigned char* bytes) {
  uint64_t word;
  std::memcpy(&word, bytes, sizeof(word));
  return (hash ^ word) * kPrime;
}

// Makes a renaming last. Not all file systems can; nothing is lost then but
// the time since the older file.
void SynchronizeFolder(const fs::path& folder) {
  const int file = open(folder.empty() ? "." : folder.c_str(),
                        O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (file >= 0) {
    fsync(file);
    close(file);
  }
}

}  // namespace

void Checksum::Add(const void* data, size_t num_bytes) {
  const auto* bytes = static_cast<const unsigned char*>(data);
  const auto add_to_rest = [&](const size_t count) {
    std::copy(bytes, bytes + count, rest_ + num_rest_);
    num_rest_ += count;
    bytes += count;
    num_bytes -= count;
  };
  if (num_rest_ > 0) {
    add_to_rest(std::min(num_bytes, sizeof(rest_) - num_rest_));
    if (num_rest_ < sizeof(rest_)) {
      return;
    }
    hash_ = AddWord(hash_, rest_);
    num_rest_ = 0;
  }
  for (; num_bytes >= sizeof(rest_); num_bytes -= sizeof(rest_)) {
    hash_ = AddWord(hash_, bytes);
    bytes += sizeof(rest_);
  }
  add_to_rest(num_bytes);
}

uint64_t Checksum::Value() const {
  uint64_t hash = hash_;
  for (size_t i = 0; i < num_rest_; ++i) {
    hash = (hash ^ rest_[i]) * kPrime;
  }
  return hash;
}

std::string Checksum::Text() const {
  char text[17];
  snprintf(
      text, sizeof(text), "%016llx", static_cast<unsigned long long>(Value()));
  return text;
}

ChecksummedFileWriter::ChecksummedFileWriter(const FileFormat& format,
                                             const std::string& path)
    : format_(format), path_(path), partial_path_(path + ".partial") {
  file_ = std::fopen(partial_path_.c_str(), "wbe");
  if (file_ == nullptr) {
    ThrowUnwritable(errno);
  }
  try {
    Write(format.magic, sizeof(format.magic));
    WriteValue(format.version);
  } catch (...) {
    std::fclose(file_);
    std::remove(partial_path_.c_str());
    throw;
  }
}

ChecksummedFileWriter::~ChecksummedFileWriter() {
  if (file_ != nullptr) {
    std::fclose(file_);
    std::remove(partial_path_.c_str());
  }
}

void ChecksummedFileWriter::Write(const void* data, const size_t num_bytes) {
  if (num_bytes == 0) {
    return;  // an empty vector has no address that fwrite takes
  }
  checksum_.Add(data, num_bytes);
  if (std::fwrite(data, 1, num_bytes, file_) != num_bytes) {
    ThrowUnwritable(errno);
  }
}

void ChecksummedFileWriter::Commit(const std::string& path_of_older) {
  WriteValue(checksum_.Value());
  // What cannot be synchronised, e.g. a pipe, says EINVAL.
  if (std::fflush(file_) != 0 ||
      (fsync(fileno(file_)) != 0 && errno != EINVAL)) {
    ThrowUnwritable(errno);
  }
  std::error_code error;
  if (!path_of_older.empty() && fs::exists(path_)) {
    fs::rename(path_, path_of_older, error);
  }
  if (!error) {
    fs::rename(partial_path_, path_, error);
  }
  if (error) {
    ThrowUnwritable(error.value());
  }
  std::fclose(file_);
  file_ = nullptr;
  SynchronizeFolder(fs::path(path_).parent_path());
}

void ChecksummedFileWriter::ThrowUnwritable(const int error_number) const {
  throw std::runtime_error(std::string("could not write the ") + format_.noun +
                           " to " + path_ + " (" + std::strerror(error_number) +
                           "); is the disk full or read-only?");
}

ChecksummedFileReader::ChecksummedFileReader(const FileFormat& format,
                                             const std::string& path)
    : path_(path), file_(std::fopen(path.c_str(), "rbe")) {
  if (file_ == nullptr) {
    throw std::runtime_error(std::string("could not open the ") + format.noun +
                             " " + path + " (" + std::strerror(errno) + ")");
  }
  std::vector<unsigned char> block(kBlockSize);
  size_t size = std::fread(block.data(), 1, block.size(), file_.get());
  uint32_t version = 0;
  uint64_t written_checksum = 0;
  if (size < kHeadSize + sizeof(written_checksum) ||
      std::memcmp(block.data(), format.magic, sizeof(format.magic)) != 0) {
    throw std::runtime_error(path + " is not a " + format.noun);
  }
  std::memcpy(&version, block.data() + sizeof(format.magic), sizeof(version));
  if (version != format.version) {
    throw OtherFormatVersion(
        path + " has the format version " + std::to_string(version) +
        ", this program reads version " + std::to_string(format.version));
  }
  // The last bytes of a block may be the checksum that ends the file, so they
  // wait for the next one.
  Checksum checksum;
  constexpr size_t kTail = sizeof(written_checksum);
  size_t num_bytes = 0;
  while (true) {
    checksum.Add(block.data(), size - kTail);
    num_bytes += size - kTail;
    std::copy(block.data() + size - kTail, block.data() + size, block.data());
    const size_t num_read =
        std::fread(block.data() + kTail, 1, block.size() - kTail, file_.get());
    if (num_read == 0) {
      break;
    }
    size = kTail + num_read;
  }
  std::memcpy(&written_checksum, block.data(), kTail);
  if (std::ferror(file_.get()) != 0 || checksum.Value() != written_checksum ||
      std::fseek(file_.get(), kHeadSize, SEEK_SET) != 0) {
    throw std::runtime_error(path + " is damaged: its checksum does not match");
  }
  num_bytes_left_ = num_bytes - kHeadSize;
}

void ChecksummedFileReader::Read(void* data, const size_t num_bytes) {
  if (num_bytes == 0) {
    return;
  }
  if (num_bytes > num_bytes_left_ ||
      std::fread(data, 1, num_bytes, file_.get()) != num_bytes) {
    throw std::runtime_error(path_ + " ends too early");
  }
  num_bytes_left_ -= num_bytes;
}

}  // namespace structnerf
