#pragma once

#include "nerf/engine/render_engine.h"

#include <chrono>

namespace structnerf {

// Where one thread's time goes. Reading the clock costs some tens of
// nanoseconds; stages take microseconds.
class StageClock {
 public:
  void Start() { begin_ = std::chrono::steady_clock::now(); }

  // Counts the time since the last Start() or Stop() for the stage.
  void Stop(const EngineStage stage) {
    const auto end = std::chrono::steady_clock::now();
    seconds_[static_cast<size_t>(stage)] +=
        std::chrono::duration<double>(end - begin_).count();
    begin_ = end;
  }

  const StageSeconds& Seconds() const { return seconds_; }

 private:
  std::chrono::steady_clock::time_point begin_;
  StageSeconds seconds_ = {};
};

}  // namespace structnerf
