#pragma once

#include "tests/support/synthetic_room.h"

namespace structnerf::room {

// Where the observations of a point put it: the least sum of squared
// reprojection errors, from `point.xyz` by Gauss-Newton.
Eigen::Vector3d TriangulatePoint(const SyntheticRoom& room,
                                 const SyntheticPoint& point);

// In pixels, as in COLMAP's Point3D::error.
double MeanReprojectionError(const SyntheticRoom& room,
                             const SyntheticPoint& point);

}  // namespace structnerf::room
