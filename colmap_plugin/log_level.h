#pragma once

#include <glog/logging.h>

namespace structnerf {

// Hides COLMAP's messages below a severity (google::GLOG_WARNING, ...) while it
// lives. The setting is that of the whole process.
class ScopedLogLevel {
 public:
  explicit ScopedLogLevel(const int min_severity)
      : previous_(FLAGS_minloglevel) {
    FLAGS_minloglevel = min_severity;
  }
  ~ScopedLogLevel() { FLAGS_minloglevel = previous_; }

  ScopedLogLevel(const ScopedLogLevel&) = delete;
  ScopedLogLevel& operator=(const ScopedLogLevel&) = delete;

 private:
  const int previous_;
};

}  // namespace structnerf
