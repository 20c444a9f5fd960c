#pragma once

#include "nerf/progress.h"

#include <cstddef>
#include <string>

namespace structnerf {

// One stage of long work that goes over items: tells how far it is, and ends it
// when told to.
class StageProgress {
 public:
  // `progress` must outlive this object. Throws Aborted if told to.
  StageProgress(const std::string& stage, Progress* progress);

  // To be called after each item. Throws Aborted if told to.
  void Report(size_t num_done, size_t num_all);

  // For work inside of an item.
  Progress* Inner() { return &inner_; }

 private:
  const std::string stage_;
  Progress* progress_;
  SilentProgress inner_;
};

}  // namespace structnerf
