#include "colmap_plugin/truth_arguments.h"

namespace structnerf {

void AddTruthArguments(DepthTruthOptions* truth,
                       std::string* input_path,
                       std::string* image_path,
                       colmap::OptionManager* manager) {
  manager->AddDefaultOption(
      "ground_truth_path",
      &truth->path,
      "Folder with 16-bit depth PNGs named after the images");
  manager->AddDefaultOption("ground_truth_mask_path",
                            &truth->mask_path,
                            "Folder with masks named alike; nothing is "
                            "compared where they are black");
  manager->AddDefaultOption(
      "depth_scale", &truth->scale, "Their value for one metre");
  manager->AddDefaultOption(
      "input_path",
      input_path,
      "Model of the original images that the truth belongs to; empty = it "
      "belongs to the undistorted images");
  manager->AddDefaultOption(
      "image_path", image_path, "Folder with those original images");
}

}  // namespace structnerf
