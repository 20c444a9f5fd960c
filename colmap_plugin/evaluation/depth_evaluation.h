#pragma once

#include "colmap_plugin/evaluation/depth_metrics.h"
#include "colmap_plugin/evaluation/truth_views.h"
#include "colmap_plugin/stage_progress.h"

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <colmap/scene/camera.h>

#include <opencv2/core.hpp>

namespace structnerf {

// A depth map of an undistorted image, model units, 0 = no value; nothing where
// there is no map.
struct PredictedDepth {
  colmap::Camera camera;
  cv::Mat1f depth;
};
using DepthSource =
    std::function<std::optional<PredictedDepth>(const std::string& image_name)>;

struct SplitDepthMetrics {
  DepthMetrics all;
  DepthMetrics textured;
  DepthMetrics untextured;
};

struct ImageDepthMetrics {
  std::string name;
  bool has_map = false;

  // In the scene's scale from structure-from-motion, or from the predictions
  // if that is not known.
  DepthMetrics metrics;

  // Median of truth / prediction; 0 = not known.
  double metres_per_unit = 0;
};

// Depth maps against truth. Three ways to turn units into metres: the scale
// from structure-from-motion, which does not depend on the maps; the median of
// truth / prediction over the scene; and the same of each image on its own, as
// the paper does, which hides what differs between images.
struct DepthEvaluation {
  size_t num_images = 0;
  size_t num_images_without_map = 0;
  double predictions_metres_per_unit = 0;  // 0 = no map has a value
  double textured_share = 0;               // of the pixels with truth

  std::optional<SplitDepthMetrics> in_sfm_scale;
  std::optional<SplitDepthMetrics> in_predictions_scale;
  std::optional<SplitDepthMetrics> in_image_scale;
  std::vector<ImageDepthMetrics> images;
};

// Evaluates the maps of `names`, all of which have truth. Every pixel with
// truth counts, also those that the undistorted image does not show.
DepthEvaluation EvaluateDepth(const std::vector<std::string>& names,
                              const DepthSource& source,
                              const SceneScale& sfm_scale,
                              TruthViews* truth,
                              StageProgress* progress);

}  // namespace structnerf
