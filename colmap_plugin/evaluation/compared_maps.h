#pragma once

#include "colmap_plugin/dense_workspace.h"
#include "colmap_plugin/evaluation/workspace_maps.h"
#include "nerf/scene.h"

#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

namespace structnerf {

// A dense workspace, ours or PatchMatch's, opened to be compared with another
// one.
class ComparedMaps {
 public:
  // Throws std::runtime_error if the model cannot be read, its cameras are not
  // undistorted, or there are no maps at all.
  explicit ComparedMaps(const std::string& workspace_path);

  const DenseWorkspace& Workspace() const { return workspace_; }
  const colmap::Reconstruction& Model() const { return model_; }

  // All registered views, without pixels.
  const std::vector<View>& Views() const { return views_; }

  // Null if there is none of this name.
  const View* FindView(const std::string& name) const;

  // Whether any view has a map of this type.
  bool Has(MapType type) const;

  // Nothing if the view has no such map.
  std::optional<PredictedDepth> Depth(const std::string& name,
                                      MapType type) const;

  // Nothing if one of the two is missing.
  std::optional<StereoMaps> DepthAndNormals(const std::string& name,
                                            MapType type) const;

 private:
  const WorkspaceMaps& MapsOf(MapType type) const;

  const DenseWorkspace workspace_;
  const colmap::Reconstruction model_;
  const WorkspaceMaps photometric_;
  const WorkspaceMaps geometric_;
  const std::vector<View> views_;
  std::unordered_map<std::string, size_t> view_idxs_;
};

}  // namespace structnerf
