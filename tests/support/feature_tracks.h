#pragma once

#include "tests/support/synthetic_room.h"

#include <vector>

#include <Eigen/Core>

namespace structnerf::room {

// An image corner, found where the surface allows it.
struct Feature {
  int image_idx = -1;
  Eigen::Vector2d xy;      // true image point
  Eigen::Vector3d xyz;     // where it lies, room frame
  Eigen::Vector3d normal;  // of the surface there, room frame
  int track_idx = -1;  // the surface point it belongs to; -1 = only seen here
};

// Corners of all images and, for each surface point that at least two images
// show as a corner under a sufficient angle, its features. The images' poses
// must be in the room's frame.
struct FeatureTracks {
  std::vector<Feature> features;
  std::vector<std::vector<int>> tracks;  // into features, first = where found
};

FeatureTracks FindFeatureTracks(const SyntheticRoom& room, int seed);

}  // namespace structnerf::room
