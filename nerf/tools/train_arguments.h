#pragma once

#include "nerf/options.h"

#include <string>
#include <vector>

namespace structnerf {

// What structnerf_train is told on its command line.
struct TrainArguments {
  std::string scene_path;
  std::string output_path;
  std::string quality = "medium";
  std::string method = "structnerf";
  std::string device = "cpu";     // of the two that ResolveDevice() returns
  ReconstructionOptions options;  // of the two, and what was given besides
};

// Reads "--name value" and "--name=value": --scene_path, --output_path, and
// --StructNeRF.quality, --StructNeRF.method, --StructNeRF.device and the
// options of the method (nerf/method_options.h) as structnerf_dense has them,
// but for max_image_size and planar_min_area, which the scene has been made
// with. Throws std::invalid_argument with a sentence about the first thing that
// is wrong.
TrainArguments ParseTrainArguments(const std::vector<std::string>& arguments);

// All arguments with their defaults and what they mean.
std::string TrainUsage();

}  // namespace structnerf
