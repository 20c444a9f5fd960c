#pragma once

#include "colmap_plugin/evaluation/depth_evaluation.h"
#include "colmap_plugin/stage_progress.h"
#include "colmap_plugin/trained_field.h"

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace structnerf {

struct HeldOutOptions {
  // TorchScript module for LPIPS; empty = do not measure it.
  std::string lpips_path;

  // Undistorted workspace (images, sparse) that has views which the evaluated
  // one, and so its structure-from-motion, never saw. Empty = the views that
  // training held out.
  std::string test_workspace_path;
};

struct HeldOutImage {
  std::string name;
  double psnr = 0;  // dB
  double ssim = 0;
  std::optional<double> lpips;
};

// What the field looks like where no photograph was trained on.
struct HeldOutEvaluation {
  std::vector<HeldOutImage> images;

  // Folder with the photographs.
  std::string image_path;

  // Rendered depth by image name, in units of the evaluated model. Values are
  // at the pixels' centres (kPixelCenter).
  std::map<std::string, PredictedDepth> depth;

  // With a test workspace: how well its model fits to that of the evaluated one
  // (ModelAlignment).
  size_t num_common_views = 0;
  double alignment_error = 0;

  double MeanPsnr() const;
  double MeanSsim() const;
  std::optional<double> MeanLpips() const;
};

// Renders all held-out views at the size of their undistorted photographs, and
// in their exposures, as far as the run has accounted for them; no images if
// there are none. Throws std::runtime_error if a photograph is
// missing, if the module for LPIPS does not work, or if the models do not fit.
HeldOutEvaluation EvaluateHeldOut(const std::string& workspace_path,
                                  const TrainedField& field,
                                  const HeldOutOptions& options,
                                  StageProgress* progress);

}  // namespace structnerf
