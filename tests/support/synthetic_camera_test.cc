#include "tests/support/synthetic_camera.h"

#include <cmath>
#include <stdexcept>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

namespace structnerf {
namespace {

TEST(SyntheticCamera, UnprojectInvertsProjectAllOverTheImage) {
  for (const std::string& model : SyntheticCameraModels()) {
    const SyntheticCamera camera = SyntheticCamera::Make(model, 320, 240, 1);
    for (int y = 0; y <= 240; y += 16) {
      for (int x = 0; x <= 320; x += 16) {
        const Eigen::Vector2d image_point(x, y);
        const Eigen::Vector3d ray = camera.Unproject(image_point);
        EXPECT_EQ(ray.z(), 1);
        EXPECT_LT((camera.Project(3.7 * ray) - image_point).norm(), 1e-8)
            << model << " at " << image_point.transpose();
      }
    }
  }
}

// A camera that ignored its distortion would pass the round trip.
TEST(SyntheticCamera, DistortionIsVisible) {
  const Eigen::Vector2d corner(0, 0);
  const Eigen::Vector3d ray =
      SyntheticCamera::Make("PINHOLE", 320, 240, 1).Unproject(corner);
  for (const char* model : {"SIMPLE_RADIAL", "OPENCV", "OPENCV_FISHEYE"}) {
    const SyntheticCamera camera = SyntheticCamera::Make(model, 320, 240, 1);
    EXPECT_GT((camera.Project(ray) - corner).norm(), 5) << model;
  }
}

TEST(SyntheticCamera, ProjectsAsComputedByHand) {
  const Eigen::Vector3d point(1, 2, 4);  // u = 0.25, v = 0.5, r^2 = 0.3125
  const SyntheticCamera pinhole{"PINHOLE", 100, 80, {100, 200, 50, 40}};
  EXPECT_TRUE(pinhole.Project(point).isApprox(Eigen::Vector2d(75, 140)));
  const SyntheticCamera radial{"SIMPLE_RADIAL", 100, 80, {100, 50, 40, 0.4}};
  EXPECT_TRUE(radial.Project(point).isApprox(Eigen::Vector2d(78.125, 96.25)));
  // Radial factor 1 + 0.32 r^2 + 1.024 r^4 = 1.2, tangential x:
  // 2 p1 u v + p2 (r^2 + 2 u^2), y: 2 p2 u v + p1 (r^2 + 2 v^2).
  const SyntheticCamera opencv{
      "OPENCV", 100, 80, {100, 200, 50, 40, 0.32, 1.024, 0.1, 0.2}};
  EXPECT_TRUE(opencv.Project(point).isApprox(
      Eigen::Vector2d(50 + 100 * (0.3 + 0.1 * 0.25 + 0.2 * 0.4375),
                      40 + 200 * (0.6 + 0.2 * 0.25 + 0.1 * 0.8125))));
  // 45 degrees to the right; theta = pi / 4.
  const SyntheticCamera fisheye{
      "OPENCV_FISHEYE", 100, 80, {100, 100, 50, 40, 0.1, 0, 0, 0}};
  const double theta = M_PI / 4;
  EXPECT_TRUE(fisheye.Project(Eigen::Vector3d(2, 0, 2))
                  .isApprox(Eigen::Vector2d(
                      50 + 100 * theta * (1 + 0.1 * theta * theta), 40)));
}

TEST(SyntheticCamera, RefusesWhatItCannotDo) {
  EXPECT_THROW(SyntheticCamera::Make("FOV", 320, 240, 1),
               std::invalid_argument);
  // r (1 - r^2) never exceeds 0.385.
  const SyntheticCamera folded{"SIMPLE_RADIAL", 100, 100, {100, 50, 50, -1}};
  EXPECT_THROW(folded.Unproject(Eigen::Vector2d(100, 50)), std::domain_error);
}

}  // namespace
}  // namespace structnerf
