#pragma once

#include "colmap_plugin/evaluation/cloud_metrics.h"
#include "colmap_plugin/evaluation/truth_views.h"
#include "colmap_plugin/stage_progress.h"

#include <cstddef>
#include <string>

namespace structnerf {

struct CloudEvaluationOptions {
  // Side in metres of the voxels that both clouds are reduced to.
  double voxel_size = 0.01;

  // Leave out predicted points where nobody measured: those that project into
  // no pixel with truth. They always are where the truth has masks.
  bool mask_unobserved = false;

  // Throws std::runtime_error, naming the option, if one is wrong.
  void Check() const;
};

struct CloudEvaluation {
  size_t num_fused_points = 0;
  size_t num_unobserved_points = 0;  // of the reduced cloud; left out
  CloudMetrics metrics;
};

// A fused cloud against all pixels with truth, back-projected with the model's
// cameras and poses. Throws std::runtime_error, naming the file, if the cloud
// cannot be read.
CloudEvaluation EvaluateCloud(const std::string& ply_path,
                              double metres_per_unit,
                              const CloudEvaluationOptions& options,
                              TruthViews* truth,
                              StageProgress* progress);

}  // namespace structnerf
