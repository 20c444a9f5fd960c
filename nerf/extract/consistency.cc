#include "nerf/reconstructor.h"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

namespace structnerf {
namespace {

// Map from the pixels of one view to those of another.
struct PixelTransfer {
  PixelTransfer(const View& from, const View& to) {
    const Eigen::Matrix3d to_matrix = to.camera.CalibrationMatrix();
    matrix = to_matrix * to.cam_from_world_rotation *
             from.cam_from_world_rotation.transpose() *
             from.camera.CalibrationMatrix().inverse();
    offset = to_matrix * to.cam_from_world_rotation *
             (from.ProjectionCenter() - to.ProjectionCenter());
  }

  // Image point and depth in `to` of an image point with a depth in `from`;
  // false if it is behind the camera.
  bool Apply(const double x,
             const double y,
             const double depth,
             Eigen::Vector3d* result) const {
    const Eigen::Vector3d in_to =
        depth * (matrix * Eigen::Vector3d(x, y, 1)) + offset;
    if (!(in_to.z() > 0)) {
      return false;
    }
    const double inverse = 1 / in_to.z();
    *result << in_to.x() * inverse, in_to.y() * inverse, in_to.z();
    return true;
  }

  // Homogeneous image point in `to`: depth * matrix * (x, y, 1) + offset.
  Eigen::Matrix3d matrix;
  Eigen::Vector3d offset;
};

bool Confirms(const PixelTransfer& forward,
              const PixelTransfer& backward,
              const DenseMaps& source,
              const int col,
              const int row,
              const double depth,
              const ExtractionOptions& options) {
  Eigen::Vector3d in_source;
  if (!forward.Apply(col, row, depth, &in_source)) {
    return false;
  }
  // Values belong to integer image points, so the nearest is by rounding.
  const double source_col = std::floor(in_source.x() + 0.5);
  const double source_row = std::floor(in_source.y() + 0.5);
  if (!(source_col >= 0 && source_row >= 0 && source_col < source.width &&
        source_row < source.height)) {
    return false;
  }
  const double source_depth =
      source.depth[static_cast<size_t>(source_row) * source.width +
                   static_cast<size_t>(source_col)];
  if (source_depth <= 0 ||
      std::abs(source_depth - in_source.z()) >
          options.max_relative_depth_error * in_source.z()) {
    return false;
  }
  Eigen::Vector3d back;
  if (!backward.Apply(in_source.x(), in_source.y(), source_depth, &back)) {
    return false;
  }
  const double dx = back.x() - col;
  const double dy = back.y() - row;
  return dx * dx + dy * dy <=
         options.max_reprojection_error * options.max_reprojection_error;
}

}  // namespace

std::vector<ConsistencyRecord> FindConsistentPixels(
    const Scene& scene,
    const std::vector<DenseMaps>& maps,
    const size_t view_idx,
    const std::vector<int>& source_view_idxs,
    const ExtractionOptions& options) {
  std::vector<int> sources = source_view_idxs;
  std::sort(sources.begin(), sources.end());
  std::vector<PixelTransfer> forward;
  std::vector<PixelTransfer> backward;
  for (const int source : sources) {
    forward.emplace_back(scene.views[view_idx], scene.views[source]);
    backward.emplace_back(scene.views[source], scene.views[view_idx]);
  }
  const DenseMaps& reference = maps[view_idx];
  std::vector<ConsistencyRecord> records;
  ConsistencyRecord record;
  for (int row = 0; row < reference.height; ++row) {
    for (int col = 0; col < reference.width; ++col) {
      const double depth =
          reference.depth[static_cast<size_t>(row) * reference.width + col];
      if (depth <= 0) {
        continue;
      }
      record.view_idxs.clear();
      for (size_t i = 0; i < sources.size(); ++i) {
        if (Confirms(forward[i],
                     backward[i],
                     maps[sources[i]],
                     col,
                     row,
                     depth,
                     options)) {
          record.view_idxs.push_back(sources[i]);
        }
      }
      if (static_cast<int>(record.view_idxs.size()) >=
          options.min_num_consistent) {
        record.col = col;
        record.row = row;
        records.push_back(record);
      }
    }
  }
  return records;
}

}  // namespace structnerf
