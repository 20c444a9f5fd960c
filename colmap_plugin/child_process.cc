#include "colmap_plugin/child_process.h"

#include "nerf/util/interrupts.h"

#include <cerrno>
#include <chrono>
#include <thread>

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

extern char** environ;

namespace structnerf {
namespace {

constexpr std::chrono::milliseconds kPollInterval(10);

}  // namespace

int RunChildProcess(const std::string& path,
                    const std::vector<std::string>& arguments,
                    const bool keep_output) {
  std::vector<std::string> strings = {path};
  strings.insert(strings.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& string : strings) {
    argv.push_back(string.data());
  }
  argv.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  if (!keep_output) {
    posix_spawn_file_actions_addopen(
        &actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  }
  pid_t pid = 0;
  int status = 0;
  const bool has_begun =
      posix_spawn(
          &pid, path.c_str(), &actions, nullptr, argv.data(), environ) == 0;
  posix_spawn_file_actions_destroy(&actions);
  if (!has_begun) {
    return -1;
  }
  bool was_told = false;
  for (pid_t ended = 0; ended != pid; ended = waitpid(pid, &status, WNOHANG)) {
    if (ended < 0 && errno != EINTR) {
      return -1;
    }
    // A terminal sends Ctrl-C to both, but `kill` only reaches this process.
    if (!was_told && ScopedInterrupts::WasTerminated()) {
      kill(pid, SIGTERM);
      was_told = true;
    }
    std::this_thread::sleep_for(kPollInterval);
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

}  // namespace structnerf
