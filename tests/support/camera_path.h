#pragma once

#include <vector>

#include <Eigen/Core>

namespace structnerf::room {

// A camera in the room. Camera axes: x right, y down, z forward.
struct CameraPose {
  Eigen::Vector3d center;
  Eigen::Matrix3d cam_from_room;
};

// `num_views` stations of a walk with a hand-held camera around the table,
// evenly spaced, with the hand's unsteadiness. If `turn_away_at_end`, the last
// two look at the south wall instead, which no other view shows.
std::vector<CameraPose> WalkThroughRoom(int num_views,
                                        bool turn_away_at_end,
                                        int seed);

}  // namespace structnerf::room
