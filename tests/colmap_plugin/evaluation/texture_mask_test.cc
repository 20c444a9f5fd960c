#include "colmap_plugin/evaluation/texture_mask.h"

#include <gtest/gtest.h>

namespace structnerf {
namespace {

double TexturedShare(const cv::Mat1b& image) {
  return static_cast<double>(cv::countNonZero(TextureMask(image))) /
         image.total();
}

TEST(TextureMaskTest, SensorNoiseIsNoTexture) {
  cv::Mat1b image(64, 64);
  cv::RNG random(1);
  random.fill(image, cv::RNG::NORMAL, 128, 3);
  EXPECT_EQ(TexturedShare(image), 0);
  random.fill(image, cv::RNG::NORMAL, 128, 12);
  EXPECT_EQ(TexturedShare(image), 1);
}

TEST(TextureMaskTest, ThresholdIsFourLevelsPerPixel) {
  for (const auto& [slope, share] : {std::pair(3, 0.0), std::pair(5, 1.0)}) {
    cv::Mat1b ramp(40, 50);
    for (int row = 0; row < ramp.rows; ++row) {
      for (int col = 0; col < ramp.cols; ++col) {
        ramp(row, col) = static_cast<uint8_t>(slope * col);
      }
    }
    // Mirrored borders flatten the ramp there.
    const cv::Mat1b inside = TextureMask(ramp).colRange(7, 43);
    EXPECT_EQ(cv::countNonZero(inside), share * inside.total()) << slope;
  }
}

TEST(TextureMaskTest, AnEdgeReachesAsFarAsTheWindow) {
  cv::Mat1b image(40, 40, static_cast<uint8_t>(50));
  image.colRange(20, 40) = 150;
  const cv::Mat1b mask = TextureMask(image);
  // Gradients at columns 19 and 20, windows of five pixels to either side.
  EXPECT_EQ(mask(20, 13), 0);
  EXPECT_EQ(mask(20, 14), 255);
  EXPECT_EQ(mask(20, 25), 255);
  EXPECT_EQ(mask(20, 26), 0);
}

}  // namespace
}  // namespace structnerf
