#include "tests/end_to_end/run_program.h"

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>

#include <fcntl.h>
#include <poll.h>
#include <pty.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

namespace structnerf {
namespace {

struct Pipe {
  int read_end = -1;
  int write_end = -1;

  explicit Pipe(const bool is_terminal = false) {
    int ends[2];
    const winsize size = {24, 80, 0, 0};
    if ((is_terminal ? openpty(&ends[0], &ends[1], nullptr, nullptr, &size)
                     : pipe2(ends, O_CLOEXEC)) != 0) {
      throw std::runtime_error("no pipe");
    }
    read_end = ends[0];
    write_end = ends[1];
  }
};

// Runs in the new process and does not return.
void Execute(const ProgramOptions& options) {
  for (const auto& [name, value] : options.environment) {
    setenv(name.c_str(), value.c_str(), /*overwrite=*/1);
  }
  if (options.max_file_size > 0) {
    std::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit = {options.max_file_size, options.max_file_size};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  if (options.max_memory > 0) {
    const rlimit limit = {options.max_memory, options.max_memory};
    setrlimit(RLIMIT_AS, &limit);
  }
  std::string program = STRUCTNERF_PROGRAM;
  std::vector<std::string> arguments = options.arguments;
  std::vector<char*> argv = {program.data()};
  for (std::string& argument : arguments) {
    argv.push_back(argument.data());
  }
  argv.push_back(nullptr);
  execv(program.c_str(), argv.data());
  _exit(127);
}

// Appends what can be read; false at the end of the stream.
bool Append(const int file, std::string* text) {
  char buffer[4096];
  const ssize_t num_bytes = read(file, buffer, sizeof(buffer));
  if (num_bytes > 0) {
    text->append(buffer, num_bytes);
  }
  return num_bytes > 0;
}

}  // namespace

Program::Program(const ProgramOptions& options) {
  const Pipe in;
  const Pipe out;
  const Pipe error(options.has_terminal);
  pid_ = fork();
  if (pid_ == 0) {
    dup2(in.read_end, STDIN_FILENO);
    dup2(out.write_end, STDOUT_FILENO);
    dup2(error.write_end, STDERR_FILENO);
    close(error.read_end);
    Execute(options);
  }
  close(in.read_end);
  close(out.write_end);
  close(error.write_end);
  if (write(in.write_end, options.input.data(), options.input.size()) !=
      static_cast<ssize_t>(options.input.size())) {
    throw std::runtime_error("the input does not fit into a pipe");
  }
  close(in.write_end);
  out_ = out.read_end;
  error_ = error.read_end;
}

Program::~Program() {
  if (pid_ > 0) {
    Signal(SIGKILL);
    Wait();
  }
}

bool Program::ReadSome(const int timeout_ms) {
  pollfd files[2] = {{out_, POLLIN, 0}, {error_, POLLIN, 0}};
  poll(files, 2, timeout_ms);
  if (files[0].revents != 0 && !Append(out_, &result_.out)) {
    close(out_);
    out_ = -1;
  }
  if (files[1].revents != 0 && !Append(error_, &result_.error)) {
    close(error_);
    error_ = -1;
  }
  return out_ >= 0 || error_ >= 0;
}

bool Program::WaitForError(const std::string& text) {
  while (result_.error.find(text) == std::string::npos) {
    if (!ReadSome()) {
      return false;
    }
  }
  return true;
}

bool Program::WaitFor(const double seconds) {
  using Clock = std::chrono::steady_clock;
  const Clock::time_point end =
      Clock::now() + std::chrono::duration_cast<Clock::duration>(
                         std::chrono::duration<double>(seconds));
  while (out_ >= 0 || error_ >= 0) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(
        end - Clock::now());
    if (left.count() <= 0) {
      return false;
    }
    ReadSome(static_cast<int>(left.count()));
  }
  return true;
}

void Program::Signal(const int signal_number) { kill(pid_, signal_number); }

void Program::TakeMemory() {
  const rlimit limit = {1, 1};
  prlimit(pid_, RLIMIT_AS, &limit, nullptr);
}

ProgramResult Program::Wait() {
  while ((out_ >= 0 || error_ >= 0) && ReadSome()) {
  }
  int status = 0;
  waitpid(pid_, &status, 0);
  pid_ = -1;
  if (WIFEXITED(status)) {
    result_.exit_code = WEXITSTATUS(status);
  } else if (WIFSIGNALED(status)) {
    result_.signal = WTERMSIG(status);
  }
  return result_;
}

ProgramResult RunProgram(const ProgramOptions& options) {
  return Program(options).Wait();
}

ProgramResult RunProgram(const std::vector<std::string>& arguments) {
  ProgramOptions options;
  options.arguments = arguments;
  return RunProgram(options);
}

std::map<std::string, std::string> ReadFolder(const std::string& path) {
  namespace fs = std::filesystem;
  std::map<std::string, std::string> contents;
  for (const auto& entry : fs::recursive_directory_iterator(path)) {
    std::string& content = contents[fs::relative(entry.path(), path).string()];
    if (entry.is_regular_file()) {
      std::ifstream file(entry.path(), std::ios::binary);
      content.assign(std::istreambuf_iterator<char>(file), {});
    }
  }
  return contents;
}

}  // namespace structnerf
