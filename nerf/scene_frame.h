#pragma once

#include "nerf/scene.h"

#include <Eigen/Core>

namespace structnerf {

// Similarity from the world of the sparse model to field coordinates, in which
// the scene box is [0, extent] with its longest side 1. All in double, since
// geo-referenced models sit at 1e6 with details of 1e-3.
struct SceneFrame {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  // world
  double scale = 1;  // field units per world unit
  Eigen::Vector3f extent = Eigen::Vector3f::Ones();

  // Smallest z-depth at which rays are sampled, and a typical depth of the
  // sparse points, in field units.
  double near = 0;
  double median_depth = 0;

  Eigen::Vector3d FieldFromWorld(const Eigen::Vector3d& x_in_world) const {
    return (x_in_world - origin) * scale;
  }
};

// The box holds the cameras and the 1st to 99th percentile of the sparse points
// (those with a track and not behind their cameras), as far as they are not out
// of all proportion to the middle half, widened by 15 %. The near depth is 0.3
// times the 1st percentile of points' depths, at least 1e-3 of their median.
// Throws std::invalid_argument if the scene has fewer than two views, no usable
// points or no extent.
SceneFrame ComputeSceneFrame(const Scene& scene);

// z of a world point in a view's camera frame, world units.
double DepthInView(const View& view, const Eigen::Vector3d& x_in_world);

}  // namespace structnerf
