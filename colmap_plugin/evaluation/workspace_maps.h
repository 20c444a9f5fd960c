#pragma once

#include "colmap_plugin/dense_workspace.h"
#include "nerf/scene.h"

#include <string>
#include <unordered_map>
#include <vector>

#include <colmap/scene/reconstruction.h>

#include <opencv2/core.hpp>

namespace structnerf {

// The maps of a dense workspace, ours or PatchMatch's, view by view.
class WorkspaceMaps {
 public:
  // Takes the maps of the `wanted` type, or the others if there are none of
  // these. Throws std::runtime_error if there are no maps at all.
  WorkspaceMaps(const std::string& path, MapType wanted);

  const DenseWorkspace& Workspace() const { return workspace_; }
  MapType Type() const { return type_; }

  // All registered views.
  const std::vector<View>& Views() const { return views_; }

  // Null if there is none of this name.
  const View* FindView(const std::string& name) const;

  // The undistorted camera of a view that exists.
  const colmap::Camera& Camera(const std::string& name) const;

  // Model units, 0 = no value; empty if the view has no map.
  cv::Mat1f Depth(const std::string& name) const;

  // Empty if one of the two is missing.
  StereoMaps DepthAndNormals(const std::string& name) const;

 private:
  bool HasMaps(MapType type) const;

  DenseWorkspace workspace_;
  colmap::Reconstruction model_;
  std::vector<View> views_;
  std::unordered_map<std::string, size_t> view_idxs_;
  MapType type_;
};

}  // namespace structnerf
