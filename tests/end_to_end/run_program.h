#pragma once

#include <map>
#include <string>
#include <vector>

#include <sys/types.h>

namespace structnerf {

struct ProgramResult {
  int exit_code = -1;  // -1 if a signal ended it
  int signal = 0;      // that signal
  std::string out;     // standard output
  std::string error;   // standard error
};

struct ProgramOptions {
  std::vector<std::string> arguments;
  std::map<std::string, std::string> environment;  // added to ours
  std::string input;                               // standard input

  // Standard error is a terminal of 80 columns.
  bool has_terminal = false;

  // Files cannot grow beyond so many bytes, as if the disk were full; 0 = no
  // limit.
  size_t max_file_size = 0;

  // The address space cannot grow beyond so many bytes, as after `ulimit -v`;
  // 0 = no limit.
  size_t max_memory = 0;
};

// A running colmap-structnerf.
class Program {
 public:
  explicit Program(const ProgramOptions& options);
  ~Program();

  // Waits until standard error contains the text; false if it ends before.
  bool WaitForError(const std::string& text);

  void Signal(int signal_number);

  // From now on it gets no more address space.
  void TakeMemory();

  // Waits so long at most; false if the program still runs then.
  bool WaitFor(double seconds);

  ProgramResult Wait();

 private:
  bool ReadSome(int timeout_ms = -1);

  pid_t pid_ = -1;
  int out_ = -1;
  int error_ = -1;
  ProgramResult result_;
};

// Runs colmap-structnerf to its end.
ProgramResult RunProgram(const ProgramOptions& options);
ProgramResult RunProgram(const std::vector<std::string>& arguments);

// Every file below a folder with its content, to see whether anything changed.
std::map<std::string, std::string> ReadFolder(const std::string& path);

}  // namespace structnerf
