#pragma once

#include "colmap_plugin/structnerf_options.h"

#include <map>
#include <string>

#include <colmap/scene/reconstruction.h>

namespace structnerf {

// The program's version and every option that the maps depend on, as a
// checkpoint knows its run by: "--StructNeRF.num_steps" and "1500". The number
// of threads is none of them.
std::map<std::string, std::string> DescribeRun(
    const StructNerfOptions& options);

// Stands for the model, and for size and time of change of the photographs and
// masks: as long as it stays the same, undistorted images need not be made
// again.
std::string InputFingerprint(const colmap::Reconstruction& reconstruction,
                             const std::string& image_path,
                             const std::string& mask_path);

}  // namespace structnerf
