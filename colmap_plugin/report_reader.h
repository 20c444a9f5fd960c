#pragma once

#include "colmap_plugin/structnerf_options.h"
#include "nerf/scene.h"

#include <string>
#include <vector>

namespace structnerf {

// What report.json of a finished run says that later commands need.
struct FinishedRun {
  StructNerfOptions options;
  double seconds = 0;      // wall time of all stages
  double cpu_seconds = 0;  // of all threads

  // Of the model's registered images, in their order; empty if the report says
  // nothing about them.
  std::vector<Exposure> exposures;
};

// Throws std::runtime_error, naming the file, if it cannot be read or is not a
// report.
FinishedRun ReadReport(const std::string& path);

}  // namespace structnerf
