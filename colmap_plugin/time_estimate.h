#pragma once

#include "colmap_plugin/structnerf_options.h"
#include "nerf/scene.h"

#include <vector>

namespace structnerf {

// Wall time in seconds that a run will roughly take on this machine with
// nothing else to do: the work that the options ask for, at rates that were
// measured on a server's core of 2023. `cameras`: of the undistorted images.
double EstimateSeconds(const StructNerfOptions& options,
                       const std::vector<PinholeCamera>& cameras);

}  // namespace structnerf
