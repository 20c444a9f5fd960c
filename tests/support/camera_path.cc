#include "tests/support/camera_path.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include <Eigen/Geometry>

namespace structnerf::room {
namespace {

using Eigen::Vector3d;

struct Station {
  Vector3d center;
  Vector3d target;
};

// Along the south side of the table, then up its east side. About 4.5 m.
const std::array<Station, 6> kStations = {{
    {{0.75, 1.05, 1.45}, {2.7, 3.3, 1.0}},
    {{1.35, 0.70, 1.50}, {2.8, 3.2, 1.0}},
    {{2.25, 0.55, 1.52}, {2.8, 3.2, 1.0}},
    {{3.20, 0.60, 1.50}, {2.5, 3.2, 1.0}},
    {{4.10, 1.05, 1.46}, {1.9, 3.0, 0.95}},
    {{4.40, 1.85, 1.42}, {1.0, 2.9, 0.95}},
}};

Vector3d CatmullRom(const Vector3d& before,
                    const Vector3d& from,
                    const Vector3d& to,
                    const Vector3d& after,
                    const double t) {
  return from + 0.5 * t *
                    (to - before +
                     t * (2 * before - 5 * from + 4 * to - after +
                          t * (3 * (from - to) + after - before)));
}

// `s` in [0, 1] from the first to the last station.
Station StationAt(const double s) {
  const int last = static_cast<int>(kStations.size()) - 1;
  const double position = s * last;
  const int idx = std::min(static_cast<int>(position), last - 1);
  const Station& before = kStations[std::max(idx - 1, 0)];
  const Station& from = kStations[idx];
  const Station& to = kStations[idx + 1];
  const Station& after = kStations[std::min(idx + 2, last)];
  const double t = position - idx;
  return {CatmullRom(before.center, from.center, to.center, after.center, t),
          CatmullRom(before.target, from.target, to.target, after.target, t)};
}

CameraPose LookAt(const Vector3d& center, const Vector3d& target) {
  CameraPose pose;
  pose.center = center;
  const Vector3d forward = (target - center).normalized();
  const Vector3d right = forward.cross(Vector3d::UnitZ()).normalized();
  pose.cam_from_room.row(0) = right.transpose();
  pose.cam_from_room.row(1) = forward.cross(right).transpose();
  pose.cam_from_room.row(2) = forward.transpose();
  return pose;
}

}  // namespace

std::vector<CameraPose> WalkThroughRoom(const int num_views,
                                        const bool turn_away_at_end,
                                        const int seed) {
  constexpr double kPositionSigma = 0.025;  // metres
  constexpr double kAngleSigma = 0.02;      // radians
  std::mt19937_64 random(seed + 1);
  std::normal_distribution<double> normal;
  const auto normal_vector = [&] {
    const double x = normal(random);
    const double y = normal(random);
    return Vector3d(x, y, normal(random));
  };
  std::vector<CameraPose> poses;
  for (int i = 0; i < num_views; ++i) {
    Station station = StationAt(i / (num_views - 1.0));
    if (turn_away_at_end && i >= num_views - 2) {
      station.target = Vector3d(0.6, 0.2, 1.15);
    }
    const Vector3d shift = kPositionSigma * normal_vector();
    const Vector3d turn = kAngleSigma * normal_vector();
    CameraPose pose = LookAt(station.center + shift, station.target);
    pose.cam_from_room =
        Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix() *
        pose.cam_from_room;
    poses.push_back(pose);
  }
  return poses;
}

}  // namespace structnerf::room
