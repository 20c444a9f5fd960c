#pragma once

#include "tests/support/primitive.h"
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

// Ray through an image point with t = z-depth, in the frame of the poses.
Ray RayThrough(const SyntheticRoom& room,
               const SyntheticImage& image,
               const Eigen::Vector2d& image_point);

}  // namespace structnerf::room
