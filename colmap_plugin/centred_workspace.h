#pragma once

#include "colmap_plugin/dense_workspace.h"

#include <string>
#include <vector>

#include <colmap/scene/reconstruction.h>

#include <Eigen/Core>

namespace structnerf {

// A dense workspace as COLMAP's fusion should see it. It computes in single
// precision, which has half a metre left of geo-referenced models at 1e7. A
// model far from the origin is therefore shown moved to it: a folder in the
// workspace holds the moved model and links to images and maps. It goes with
// this object.
class CentredWorkspace {
 public:
  // Whether a model is far from the origin, so that links are needed.
  static bool IsNeeded(const colmap::Reconstruction& reconstruction);

  // Throws std::runtime_error if the folder cannot be made.
  explicit CentredWorkspace(const DenseWorkspace& workspace);
  ~CentredWorkspace();

  CentredWorkspace(const CentredWorkspace&) = delete;
  CentredWorkspace& operator=(const CentredWorkspace&) = delete;

  // The workspace itself if its model is near the origin.
  const std::string& Path() const { return path_; }

  // x_in_world = x_in_centred + Offset(); zero near the origin.
  const Eigen::Vector3d& Offset() const { return offset_; }

  // For each image of the model at Path(), in its order, the number of the same
  // image in the workspace's own model.
  const std::vector<int>& ImageIdxs() const { return image_idxs_; }

 private:
  std::string path_;
  std::string folder_;  // to be removed; empty = none
  Eigen::Vector3d offset_ = Eigen::Vector3d::Zero();
  std::vector<int> image_idxs_;
};

}  // namespace structnerf
