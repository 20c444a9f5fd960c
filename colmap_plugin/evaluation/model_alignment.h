#pragma once

#include "nerf/scene.h"

#include <cstddef>
#include <vector>

#include <Eigen/Core>

namespace structnerf {

// x_in_target = scale * rotation * x_in_source + translation.
struct ModelAlignment {
  double scale = 1;
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();

  size_t num_common_views = 0;

  // Root mean square of what is left between the projection centres of common
  // views, divided by that of their distance to their mean.
  double relative_error = 0;

  // The same camera in the target's world.
  View Apply(const View& view) const;
};

// Aligns two models by the views they have in common: rotation as the mean of
// what their orientations say, scale and translation by least squares of the
// centres. Throws std::runtime_error if they have fewer than two views at
// different places in common.
ModelAlignment AlignModels(const std::vector<View>& source,
                           const std::vector<View>& target);

}  // namespace structnerf
