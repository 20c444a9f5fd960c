#pragma once

#include "nerf/util/state_stream.h"

#include <cstdint>
#include <cstdio>
#include <memory>
#include <stdexcept>
#include <string>

namespace structnerf {

// FNV-1a over 64-bit words and the rest byte by byte, of bytes that come in any
// portions. Any change of a single word changes it.
class Checksum {
 public:
  void Add(const void* data, size_t num_bytes);
  uint64_t Value() const;

  // 16 hexadecimal digits.
  std::string Text() const;

 private:
  uint64_t hash_ = 14695981039346656037ULL;
  unsigned char rest_[8] = {};
  size_t num_rest_ = 0;
};

// A kind of file: eight bytes to know it by, the version of its format, and
// what it is called in messages, e.g. "trained field".
struct FileFormat {
  char magic[8];
  uint32_t version;
  const char* noun;
};

// Writes a file beside its name, with its format in front and a checksum over
// all of it at the end, and renames it when it is complete. A process that is
// killed, or a machine that loses power, at any time leaves the old file or the
// new one. All functions throw std::runtime_error, naming the file, if the
// disk is full or cannot be written.
class ChecksummedFileWriter : public StateWriter {
 public:
  ChecksummedFileWriter(const FileFormat& format, const std::string& path);

  // Removes the unfinished file, unless committed.
  ~ChecksummedFileWriter() override;

  ChecksummedFileWriter(const ChecksummedFileWriter&) = delete;
  ChecksummedFileWriter& operator=(const ChecksummedFileWriter&) = delete;

  void Write(const void* data, size_t num_bytes) override;

  // Completes the file and gives it its name. An older file of this name is
  // kept under another one, unless that is empty.
  void Commit(const std::string& path_of_older = "");

 private:
  [[noreturn]] void ThrowUnwritable(int error_number) const;

  const FileFormat format_;
  const std::string path_;
  const std::string partial_path_;
  std::FILE* file_ = nullptr;
  Checksum checksum_;
};

// A file that another version of the program has written.
class OtherFormatVersion : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Reads such a file. Nothing is handed out before all of it is known to be
// intact.
class ChecksummedFileReader : public StateReader {
 public:
  // Throws std::runtime_error, naming the file and what is wrong, if it cannot
  // be read, is of another format, or damaged, and OtherFormatVersion if that
  // is it.
  ChecksummedFileReader(const FileFormat& format, const std::string& path);

  void Read(void* data, size_t num_bytes) override;
  size_t NumBytesLeft() const override { return num_bytes_left_; }

 private:
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };

  const std::string path_;
  std::unique_ptr<std::FILE, Close> file_;
  size_t num_bytes_left_ = 0;  // before the checksum
};

}  // namespace structnerf
