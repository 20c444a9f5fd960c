#include "nerf/extract/depth_averaging.h"

#include "nerf/extract/consistency_graph.h"
#include "nerf/pixel_transfer.h"
#include "nerf/watched_loop.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include <Eigen/Core>

namespace structnerf {
namespace {

// Another view, as seen from the view whose depth is averaged.
class OtherView {
 public:
  OtherView(const View& view, const View& other, const DenseMaps& confirmed)
      : forward_(view, view.camera, other, other.camera),
        backward_(other, other.camera, view, view.camera),
        maps_(confirmed) {}

  // The depth of a pixel by the surface that this view sees there, divided by
  // the pixel's own; 0 if it is another surface, or none.
  double RelativeDepth(const double x,
                       const double y,
                       const double depth,
                       const double max_error) const {
    Eigen::Vector3d there;
    if (!forward_.Apply(x, y, depth, &there)) {
      return 0;
    }
    const double surface_depth = DepthAt(there, max_error);
    if (surface_depth == 0) {
      return 0;
    }
    const double ratio =
        backward_.Depth(there.x(), there.y(), surface_depth) / depth;
    return std::abs(ratio - 1) <= max_error ? ratio : 0;
  }

 private:
  // Interpolated linearly in its inverse, as it is on a plane; 0 unless all
  // four values around the image point `there` are near the depth of that.
  double DepthAt(const Eigen::Vector3d& there, const double max_error) const {
    const double left = std::floor(there.x());
    const double top = std::floor(there.y());
    if (!(left >= 0 && top >= 0 && left + 1 < maps_.width &&
          top + 1 < maps_.height)) {
      return 0;
    }
    const float* const upper = maps_.depth.data() +
                               static_cast<size_t>(top) * maps_.width +
                               static_cast<size_t>(left);
    const float* const lower = upper + maps_.width;
    const double max_difference = max_error * there.z();
    for (const float depth : {upper[0], upper[1], lower[0], lower[1]}) {
      if (depth <= 0 || std::abs(depth - there.z()) > max_difference) {
        return 0;
      }
    }
    const double right_share = there.x() - left;
    const double lower_share = there.y() - top;
    return 1 / ((1 - lower_share) *
                    ((1 - right_share) / upper[0] + right_share / upper[1]) +
                lower_share *
                    ((1 - right_share) / lower[0] + right_share / lower[1]));
  }

  const PixelTransfer forward_;
  const PixelTransfer backward_;
  const DenseMaps& maps_;
};

}  // namespace

DepthAgreement AverageDepth(const Scene& scene,
                            const std::vector<DenseMaps>& confirmed,
                            const size_t view_idx,
                            const std::vector<int>& averaging_view_idxs,
                            const ExtractionOptions& options,
                            ThreadPool* pool,
                            Progress* progress,
                            std::vector<float>* depth) {
  const View& view = scene.views[view_idx];
  std::vector<int> ascending = averaging_view_idxs;
  std::sort(ascending.begin(), ascending.end());
  std::vector<OtherView> others;
  for (const int other_idx : ascending) {
    others.emplace_back(view, scene.views[other_idx], confirmed[other_idx]);
  }
  ConsistencyGraphBuilder graph(view.camera.height);
  DepthAgreement agreement;
  agreement.is_confirmed.assign(depth->size(), 0);
  agreement.num_depths.assign(depth->size(), 0);
  agreement.spread.assign(depth->size(), 0.0f);
  const auto average_row = [&](const size_t item, int) {
    const int row = static_cast<int>(item);
    std::vector<int> agreeing;
    for (int col = 0; col < view.camera.width; ++col) {
      const size_t i = item * view.camera.width + col;
      const double own_depth = (*depth)[i];
      if (own_depth <= 0) {
        continue;
      }
      agreeing.clear();
      // Of the relative differences from the pixel's own depth.
      double sum = 0;
      double sum_of_squares = 0;
      for (size_t other = 0; other < others.size(); ++other) {
        const double ratio = others[other].RelativeDepth(
            col, row, own_depth, options.averaging_max_depth_error);
        if (ratio > 0) {
          sum += ratio - 1;
          sum_of_squares += (ratio - 1) * (ratio - 1);
          agreeing.push_back(ascending[other]);
        }
      }
      const int num_depths = static_cast<int>(agreeing.size()) +
                             (confirmed[view_idx].depth[i] > 0);
      if (num_depths == 0) {
        continue;
      }
      const double mean = sum / num_depths;
      const double variance = sum_of_squares / num_depths - mean * mean;
      (*depth)[i] = static_cast<float>(own_depth * (1 + mean));
      agreement.num_depths[i] = static_cast<uint16_t>(num_depths);
      agreement.spread[i] =
          static_cast<float>(std::sqrt(std::max(0.0, variance)));
      if (num_depths >= options.min_num_consistent) {
        agreement.is_confirmed[i] = 1;
        graph.Add(col, row, agreeing);
      }
    }
  };
  WatchedParallelFor(view.camera.height, pool, progress, average_row);
  agreement.graph = graph.Build();
  return agreement;
}

}  // namespace structnerf
