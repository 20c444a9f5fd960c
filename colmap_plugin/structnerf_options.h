#pragma once

#include "nerf/options.h"

#include <string>

#include <colmap/mvs/fusion.h>

namespace structnerf {

// Everything a run of the dense stage can be told.
struct StructNerfOptions {
  // Either the original images and a new workspace that they are undistorted
  // into ...
  std::string image_path;
  std::string output_path;

  // ... or a workspace that image_undistorter has made.
  std::string workspace_path;

  // Masks in COLMAP's naming, of the original images or, with
  // `workspace_path`, of the undistorted ones. Empty = none.
  std::string mask_path;

  // Replace dense results that exist already.
  bool overwrite = false;

  // Quality and method (nerf/methods.h) that `reconstruction` was made from.
  std::string quality = "medium";
  std::string method = "structnerf";
  ReconstructionOptions reconstruction;

  // Where the field is trained and rendered: "auto", "cpu" or "cuda"
  // (nerf/engine/devices.h).
  std::string device = "cpu";

  // Depth priors for what asks for them (ReconstructionOptions::NeedsPrior): a
  // folder of depth maps in COLMAP's format, "geometric" or "photometric" ones,
  // or a TorchScript module (nerf/prior_module.h). Empty = none.
  std::string prior_path;
  std::string prior_type = "geometric";

  // File that the scene is written to before training (nerf/scene_file.h), as
  // structnerf_train reads it on machines without COLMAP. Empty = none.
  std::string export_path;

  // Memory to stay within, in GB; not positive = three quarters of what the
  // machine has.
  double max_memory_gb = -1;

  // Wall time that the run may take; 0 = as long as it does. Training is
  // shortened to fit.
  double max_minutes = 0;

  // Time between two checkpoints of the training; 0 = none.
  double checkpoint_minutes = 5;

  // Go on with a run that was killed in the same output folder, if there is
  // one; otherwise its remains are removed.
  bool resume = true;

  // Maps that are fused: "geometric" or "photometric".
  std::string input_type = "geometric";

  // min_num_pixels 0 = chosen from the number of views.
  colmap::mvs::StereoFusionOptions fusion;

  StructNerfOptions() { fusion.min_num_pixels = 0; }

  // The folder that the results end up in.
  const std::string& ResultPath() const {
    return workspace_path.empty() ? output_path : workspace_path;
  }
};

}  // namespace structnerf
