#pragma once

#include <vector>

#include <Eigen/Core>

namespace structnerf {

// The direction that most surfaces of a scene face: that of floor and tables in
// a room. The others of a room mostly stand upright on them.
struct DominantDirection {
  Eigen::Vector3f direction = Eigen::Vector3f::Zero();  // unit, sign is open
  float share = 0;  // of the normals that are within 8 degrees of it
};

// `normals`: unit normals in one frame; opposite ones count as the same.
DominantDirection FindDominantDirection(
    const std::vector<Eigen::Vector3f>& normals);

}  // namespace structnerf
