#pragma once

#include "colmap_plugin/dense_workspace.h"
#include "colmap_plugin/evaluation/depth_evaluation.h"

#include <optional>
#include <string>
#include <unordered_map>

#include <colmap/scene/reconstruction.h>

namespace structnerf {

// The depth maps of one type in a dense workspace, ours or PatchMatch's, by
// image name.
class WorkspaceMaps {
 public:
  // `model`: the undistorted one of the workspace.
  WorkspaceMaps(const DenseWorkspace& workspace,
                const colmap::Reconstruction& model,
                MapType type);

  // Whether any registered image has a map.
  bool HasAny() const;

  // Nothing if there is no such registered image or no map of it. Throws
  // std::runtime_error, naming the file, if the map is damaged.
  std::optional<PredictedDepth> Find(const std::string& name) const;

 private:
  const DenseWorkspace workspace_;
  const MapType type_;
  std::unordered_map<std::string, colmap::Camera> cameras_;
};

}  // namespace structnerf
