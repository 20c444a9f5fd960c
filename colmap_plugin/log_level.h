#pragma once

#include <algorithm>
#include <mutex>

#include <glog/logging.h>

namespace structnerf {

// Hides COLMAP's messages below a severity (google::GLOG_WARNING, ...) while it
// lives, unless more of them were asked for (--log_level 1 or more). The
// setting is that of the whole process: where several live at a time, in
// whatever threads, the last to go restores what was before the first.
class ScopedLogLevel {
 public:
  explicit ScopedLogLevel(const int min_severity) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (num_alive_++ == 0) {
      previous_ = FLAGS_minloglevel;
    }
    if (FLAGS_v <= 0) {
      FLAGS_minloglevel = std::max<int>(FLAGS_minloglevel, min_severity);
    }
  }
  ~ScopedLogLevel() {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (--num_alive_ == 0) {
      FLAGS_minloglevel = previous_;
    }
  }

  ScopedLogLevel(const ScopedLogLevel&) = delete;
  ScopedLogLevel& operator=(const ScopedLogLevel&) = delete;

 private:
  inline static std::mutex mutex_;
  inline static int num_alive_ = 0;
  inline static int previous_ = 0;
};

}  // namespace structnerf
