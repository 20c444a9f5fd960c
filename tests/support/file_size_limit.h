#pragma once

#include <csignal>

#include <sys/resource.h>

namespace structnerf {

// Files cannot grow beyond a number of bytes, as if the disk were full.
class ScopedFileSizeLimit {
 public:
  explicit ScopedFileSizeLimit(const rlim_t num_bytes)
      : previous_handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    getrlimit(RLIMIT_FSIZE, &previous_);
    const rlimit limit = {num_bytes, previous_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
  }

  ~ScopedFileSizeLimit() {
    setrlimit(RLIMIT_FSIZE, &previous_);
    std::signal(SIGXFSZ, previous_handler_);
  }

  ScopedFileSizeLimit(const ScopedFileSizeLimit&) = delete;
  ScopedFileSizeLimit& operator=(const ScopedFileSizeLimit&) = delete;

 private:
  rlimit previous_;
  void (*previous_handler_)(int);
};

}  // namespace structnerf
