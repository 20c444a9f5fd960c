#pragma once

#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include <Eigen/Core>

namespace structnerf {

// Reduces points, added one at a time, to the mean of those in each voxel, so
// that clouds of different density can be compared.
class VoxelCloud {
 public:
  // `voxel_size` in the unit of the points.
  explicit VoxelCloud(double voxel_size) : voxel_size_(voxel_size) {}

  // Points that are not finite or lie farther than a million voxels from the
  // origin are left out; returns whether it was not.
  bool Add(const Eigen::Vector3d& point);

  // In no particular order, but the same each time.
  std::vector<Eigen::Vector3d> Points() const;

 private:
  struct Voxel {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    size_t num_points = 0;
  };

  const double voxel_size_;
  std::unordered_map<int64_t, size_t> voxel_idxs_;
  std::vector<Voxel> voxels_;
};

}  // namespace structnerf
