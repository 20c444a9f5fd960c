#pragma once

#include "tests/support/synthetic_room.h"

namespace structnerf::room {

Eigen::Vector3d CameraCenter(const SyntheticImage& image);

Eigen::Vector3d PointInCamera(const SyntheticImage& image,
                              const Eigen::Vector3d& xyz);

// Image point of a point in front of the camera.
Eigen::Vector2d ProjectPoint(const SyntheticRoom& room,
                             const SyntheticImage& image,
                             const Eigen::Vector3d& xyz);

// Whether an image would show a point if nothing were in between.
bool IsInView(const SyntheticRoom& room,
              const SyntheticImage& image,
              const Eigen::Vector3d& xyz);

const SyntheticObservation& ObservationOf(const SyntheticRoom& room,
                                          const SyntheticTrackElement& element);

// Where the observations of a point put it: the least sum of squared
// reprojection errors, from `point.xyz` by Gauss-Newton.
Eigen::Vector3d TriangulatePoint(const SyntheticRoom& room,
                                 const SyntheticPoint& point);

// In pixels, as in COLMAP's Point3D::error.
double MeanReprojectionError(const SyntheticRoom& room,
                             const SyntheticPoint& point);

}  // namespace structnerf::room
