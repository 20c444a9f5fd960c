#pragma once

#include "colmap_plugin/evaluation/depth_truth.h"

#include <string>

#include <colmap/controllers/option_manager.h>

namespace structnerf {

// The options of commands that measure against ground truth:
// --ground_truth_path, --depth_scale, and --input_path and --image_path of the
// images that it belongs to.
void AddTruthArguments(DepthTruthOptions* truth,
                       std::string* input_path,
                       std::string* image_path,
                       colmap::OptionManager* manager);

}  // namespace structnerf
