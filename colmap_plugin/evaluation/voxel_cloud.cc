#include "colmap_plugin/evaluation/voxel_cloud.h"

#include <cmath>

namespace structnerf {
namespace {

// Off the round numbers: truth lies on whole millimetres, and rounding errors
// would choose the voxel.
constexpr double kOffset = 0.3137;

constexpr int kBitsPerAxis = 21;
constexpr int64_t kHalfRange = int64_t{1} << (kBitsPerAxis - 1);

}  // namespace

bool VoxelCloud::Add(const Eigen::Vector3d& point) {
  if (!point.allFinite()) {
    return false;
  }
  int64_t key = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const double cell = std::floor(point[axis] / voxel_size_ + kOffset);
    if (std::abs(cell) >= kHalfRange) {
      return false;
    }
    key = (key << kBitsPerAxis) | (static_cast<int64_t>(cell) + kHalfRange);
  }
  const auto [entry, is_new] = voxel_idxs_.emplace(key, voxels_.size());
  if (is_new) {
    voxels_.emplace_back();
  }
  Voxel& voxel = voxels_[entry->second];
  voxel.sum += point;
  ++voxel.num_points;
  return true;
}

std::vector<Eigen::Vector3d> VoxelCloud::Points() const {
  std::vector<Eigen::Vector3d> points;
  points.reserve(voxels_.size());
  for (const Voxel& voxel : voxels_) {
    points.push_back(voxel.sum / static_cast<double>(voxel.num_points));
  }
  return points;
}

}  // namespace structnerf
