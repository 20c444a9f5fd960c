#pragma once

#include "nerf/scene.h"
#include "tests/support/camera_path.h"
#include "tests/support/room_model.h"
#include "tests/support/synthetic_camera.h"

#include <vector>

#include <Eigen/Core>

namespace structnerf::room {

// Takes photographs of a room with one camera.
class Photographer {
 public:
  Photographer(const RoomModel& model, const SyntheticCamera& camera);

  // `exposure` is a factor on the linear light, `noise_sigma` the standard
  // deviation of independent noise in grey levels, drawn from `seed`.
  RgbImage TakePhotograph(const CameraPose& pose,
                          double exposure,
                          double noise_sigma,
                          int seed) const;

 private:
  const RoomModel& model_;
  int width_;
  int height_;
  // Points on the plane z = 1 behind every pixel's samples.
  std::vector<Eigen::Vector2d> sample_rays_;
};

}  // namespace structnerf::room
