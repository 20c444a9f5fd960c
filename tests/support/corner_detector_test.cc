#include "tests/support/corner_detector.h"

#include <algorithm>
#include <random>

#include <gtest/gtest.h>

namespace structnerf::room {
namespace {

RgbImage GrayImage(const int width, const int height, const uint8_t value) {
  return {width, height, std::vector<uint8_t>(3 * width * height, value)};
}

TEST(DetectCorners, FindsTheCornersOfASquareAndNotItsEdges) {
  RgbImage image = GrayImage(60, 50, 50);
  for (int row = 15; row < 35; ++row) {
    for (int col = 20; col < 45; ++col) {
      std::fill_n(&image.data[3 * (row * 60 + col)], 3, 200);
    }
  }
  const std::vector<Eigen::Vector2d> corners = DetectCorners(image, 5, 3);
  for (const Eigen::Vector2d& corner : {Eigen::Vector2d(20, 15),
                                        Eigen::Vector2d(45, 15),
                                        Eigen::Vector2d(20, 35),
                                        Eigen::Vector2d(45, 35)}) {
    EXPECT_TRUE(std::any_of(
        corners.begin(), corners.end(), [&](const Eigen::Vector2d& found) {
          return (found - corner).norm() < 2.5;
        }));
  }
  for (const Eigen::Vector2d& found : corners) {
    const bool is_near_corner =
        std::min(std::abs(found.x() - 20), std::abs(found.x() - 45)) < 4 &&
        std::min(std::abs(found.y() - 15), std::abs(found.y() - 35)) < 4;
    EXPECT_TRUE(is_near_corner) << found.transpose();
  }
}

TEST(DetectCorners, IgnoresNoise) {
  RgbImage image = GrayImage(100, 100, 0);
  std::mt19937 random(0);
  std::normal_distribution<double> noise(128, 1.2);
  for (uint8_t& value : image.data) {
    value = static_cast<uint8_t>(noise(random));
  }
  EXPECT_TRUE(DetectCorners(image, 4, 2).empty());
  EXPECT_FALSE(DetectCorners(image, 0.1, 2).empty());
}

}  // namespace
}  // namespace structnerf::room
