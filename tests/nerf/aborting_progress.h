#pragma once

#include "nerf/progress.h"

namespace structnerf {

// Told to abort from the start.
class AbortingProgress : public Progress {
 public:
  bool ShouldAbort() override { return true; }
};

}  // namespace structnerf
