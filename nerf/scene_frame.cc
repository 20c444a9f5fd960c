#include "nerf/scene_frame.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

namespace structnerf {
namespace {

constexpr double kLowPercentile = 0.01;
constexpr double kHighPercentile = 0.99;
constexpr double kMargin = 0.15;

// Wrong points lie far from the others. The box ends at the latest this many
// times the spread of the middle half of the points beyond that half. The
// spread is that of the axis where it is largest: in a flat scene what stands
// in front of the wall is not wrong.
constexpr double kMaxReach = 3;

constexpr double kNearFactor = 0.3;

// Least near depth, relative to the median depth of the points.
constexpr double kMinNear = 1e-3;

// A box must not be flatter than this share of its longest side, or
// grid levels degenerate.
constexpr double kMinSideRatio = 0.05;

double Percentile(std::vector<double>* values, const double share) {
  const size_t rank = static_cast<size_t>(share * (values->size() - 1) + 0.5);
  std::nth_element(values->begin(), values->begin() + rank, values->end());
  return (*values)[rank];
}

}  // namespace

double DepthInView(const View& view, const Eigen::Vector3d& x_in_world) {
  return view.cam_from_world_rotation.row(2).dot(x_in_world) +
         view.cam_from_world_translation.z();
}

SceneFrame ComputeSceneFrame(const Scene& scene) {
  if (scene.views.size() < 2) {
    throw std::invalid_argument(
        "the sparse model has fewer than two registered images, but depth "
        "needs at least two");
  }
  std::vector<double> depths;
  std::vector<double> coordinates[3];
  for (const SparsePoint& point : scene.points) {
    bool is_usable = false;
    for (const Observation& observation : point.track) {
      const double depth =
          DepthInView(scene.views[observation.view_idx], point.xyz);
      if (depth > 0) {
        depths.push_back(depth);
        is_usable = true;
      }
    }
    if (is_usable) {
      for (int axis = 0; axis < 3; ++axis) {
        coordinates[axis].push_back(point.xyz[axis]);
      }
    }
  }
  if (depths.empty()) {
    throw std::invalid_argument(
        "the sparse model has no points in front of its images, but the scale "
        "of the scene comes from them");
  }

  const auto box_corner = [&](const double percentile) {
    return Eigen::Vector3d(Percentile(&coordinates[0], percentile),
                           Percentile(&coordinates[1], percentile),
                           Percentile(&coordinates[2], percentile));
  };
  const Eigen::Vector3d middle_min = box_corner(0.25);
  const Eigen::Vector3d middle_max = box_corner(0.75);
  const Eigen::Vector3d reach = Eigen::Vector3d::Constant(
      kMaxReach * (middle_max - middle_min).maxCoeff());
  Eigen::Vector3d box_min =
      box_corner(kLowPercentile).cwiseMax(middle_min - reach);
  Eigen::Vector3d box_max =
      box_corner(kHighPercentile).cwiseMin(middle_max + reach);
  for (const View& view : scene.views) {
    const Eigen::Vector3d center = view.ProjectionCenter();
    box_min = box_min.cwiseMin(center);
    box_max = box_max.cwiseMax(center);
  }
  const double longest_side = (box_max - box_min).maxCoeff();
  if (!(longest_side > 0)) {
    throw std::invalid_argument(
        "all cameras and points of the sparse model are in one place");
  }
  const Eigen::Vector3d center = 0.5 * (box_min + box_max);
  const Eigen::Vector3d sides =
      (box_max - box_min).cwiseMax(kMinSideRatio * longest_side) +
      Eigen::Vector3d::Constant(2 * kMargin * longest_side);

  SceneFrame frame;
  frame.origin = center - 0.5 * sides;
  frame.scale = 1.0 / sides.maxCoeff();
  frame.extent = (sides * frame.scale).cast<float>();
  frame.median_depth = Percentile(&depths, 0.5) * frame.scale;
  frame.near =
      std::max(kNearFactor * Percentile(&depths, kLowPercentile) * frame.scale,
               kMinNear * frame.median_depth);
  return frame;
}

}  // namespace structnerf
