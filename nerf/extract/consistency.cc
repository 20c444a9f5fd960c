#include "nerf/extract/consistency.h"

#include "nerf/extract/consistency_graph.h"
#include "nerf/extract/map_resolution.h"
#include "nerf/pixel_transfer.h"
#include "nerf/util/median.h"
#include "nerf/view_selection.h"
#include "nerf/watched_loop.h"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

namespace structnerf {
namespace {

bool Confirms(const PixelTransfer& forward,
              const PixelTransfer& backward,
              const DenseMaps& source,
              const int col,
              const int row,
              const double depth,
              const double max_relative_depth_error,
              const double max_reprojection_error) {
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
  if (source_depth <= 0 || std::abs(source_depth - in_source.z()) >
                               max_relative_depth_error * in_source.z()) {
    return false;
  }
  Eigen::Vector3d back;
  if (!backward.Apply(in_source.x(), in_source.y(), source_depth, &back)) {
    return false;
  }
  const double dx = back.x() - col;
  const double dy = back.y() - row;
  return dx * dx + dy * dy <= max_reprojection_error * max_reprojection_error;
}

constexpr double kDegrees = 180.0 / M_PI;

// A source view, as seen from the view that is checked.
struct Source {
  Source(const Scene& scene,
         const std::vector<DenseMaps>& all_maps,
         const View& reference,
         const int idx)
      : view_idx(idx),
        forward(reference,
                reference.camera,
                scene.views[idx],
                scene.views[idx].camera),
        backward(scene.views[idx],
                 scene.views[idx].camera,
                 reference,
                 reference.camera),
        maps(&all_maps[idx]),
        center(reference.CamFromWorld(scene.views[idx].ProjectionCenter())) {}

  int view_idx;
  PixelTransfer forward;
  PixelTransfer backward;
  const DenseMaps* maps;
  Eigen::Vector3d center;  // in the reference camera's frame
};

// Largest angle between any two rays that see a sparse point, in degrees.
double WidestAngle(const SparsePoint& point,
                   const std::vector<Eigen::Vector3d>& centers) {
  double widest = 0;
  for (size_t i = 0; i < point.track.size(); ++i) {
    for (size_t j = i + 1; j < point.track.size(); ++j) {
      widest = std::max(widest,
                        TriangulationAngle(centers[point.track[i].view_idx],
                                           centers[point.track[j].view_idx],
                                           point.xyz));
    }
  }
  return kDegrees * widest;
}

}  // namespace

ViewConsistency CheckConsistency(const Scene& scene,
                                 const std::vector<DenseMaps>& maps,
                                 const size_t view_idx,
                                 const std::vector<int>& source_view_idxs,
                                 const ExtractionOptions& options,
                                 ThreadPool* pool,
                                 Progress* progress) {
  std::vector<int> ascending = source_view_idxs;
  std::sort(ascending.begin(), ascending.end());
  std::vector<Source> sources;
  for (const int source_idx : ascending) {
    sources.emplace_back(scene, maps, scene.views[view_idx], source_idx);
  }
  const DenseMaps& reference = maps[view_idx];
  const Eigen::Matrix3d ray_from_pixel =
      scene.views[view_idx].camera.CalibrationMatrix().inverse();
  const double max_reprojection_error =
      options.max_reprojection_error *
      PixelsPerReferencePixel(scene.views[view_idx].camera);
  ViewConsistency consistency;
  consistency.is_confirmed.assign(reference.depth.size(), 0);
  consistency.angles.assign(reference.depth.size(), 0.0f);
  ConsistencyGraphBuilder graph(reference.height);
  const auto check_row = [&](const size_t item, int) {
    const int row = static_cast<int>(item);
    std::vector<int> confirming;
    for (int col = 0; col < reference.width; ++col) {
      const size_t pixel = static_cast<size_t>(row) * reference.width + col;
      const double depth = reference.depth[pixel];
      if (depth <= 0) {
        continue;
      }
      const Eigen::Vector3d in_reference =
          depth * (ray_from_pixel * Eigen::Vector3d(col, row, 1));
      const Eigen::Vector3d direction = in_reference.normalized();
      const Source* widest = nullptr;
      double smallest_cosine = 2;
      confirming.clear();
      for (const Source& source : sources) {
        if (Confirms(source.forward,
                     source.backward,
                     *source.maps,
                     col,
                     row,
                     depth,
                     options.max_relative_depth_error,
                     max_reprojection_error)) {
          confirming.push_back(source.view_idx);
          const Eigen::Vector3d ray = in_reference - source.center;
          const double cosine = ray.dot(direction) / ray.norm();
          if (cosine < smallest_cosine) {
            smallest_cosine = cosine;
            widest = &source;
          }
        }
      }
      const double angle =
          widest == nullptr
              ? 0.0
              : kDegrees * TriangulationAngle(Eigen::Vector3d::Zero(),
                                              widest->center,
                                              in_reference);
      consistency.angles[pixel] = static_cast<float>(angle);
      if (static_cast<int>(confirming.size()) >= options.min_num_consistent &&
          angle >= options.min_triangulation_angle) {
        consistency.is_confirmed[pixel] = 1;
        graph.Add(col, row, confirming);
      }
    }
  };
  WatchedParallelFor(reference.height, pool, progress, check_row);
  consistency.graph = graph.Build();
  return consistency;
}

void ReplaceUnconfirmed(const std::vector<uint8_t>& is_confirmed,
                        const DenseMaps& other,
                        DenseMaps* maps) {
  const size_t num_pixels = maps->depth.size();
  for (size_t i = 0; i < num_pixels; ++i) {
    if (is_confirmed[i] || maps->depth[i] == 0) {
      continue;
    }
    maps->depth[i] = other.depth[i];
    for (size_t axis = 0; axis < 3; ++axis) {
      maps->normal[axis * num_pixels + i] = other.normal[axis * num_pixels + i];
    }
  }
}

ExtractionOptions FitToScene(const ExtractionOptions& options,
                             const Scene& scene,
                             const size_t num_sources) {
  ExtractionOptions fitted = options;
  fitted.min_num_consistent =
      std::min(options.min_num_consistent, static_cast<int>(num_sources) - 1);
  std::vector<Eigen::Vector3d> centers;
  for (const View& view : scene.views) {
    centers.push_back(view.ProjectionCenter());
  }
  std::vector<double> angles;
  for (const SparsePoint& point : scene.points) {
    if (point.track.size() >= 2) {
      angles.push_back(WidestAngle(point, centers));
    }
  }
  if (!angles.empty()) {
    fitted.min_triangulation_angle =
        std::min(options.min_triangulation_angle, 0.5 * Median(&angles));
  }
  return fitted;
}

}  // namespace structnerf
