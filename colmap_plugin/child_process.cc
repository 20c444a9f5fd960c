#include "colmap_plugin/child_process.h"

#include <cerrno>

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

extern char** environ;

namespace structnerf {

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
  while (waitpid(pid, &status, 0) != pid) {
    if (errno != EINTR) {  // a signal of ours is the program's business, too
      return -1;
    }
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

}  // namespace structnerf
