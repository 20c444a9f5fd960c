#include "colmap_plugin/superpixels.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace structnerf {
namespace {

using testing::Each;

// Three vertical stripes of 20, 40 and 60 columns and 50 rows.
RgbImage MakeStripes() {
  RgbImage image{120, 50, {}};
  for (int row = 0; row < image.height; ++row) {
    for (int col = 0; col < image.width; ++col) {
      const uint8_t level = col < 20 ? 10 : col < 60 ? 120 : 240;
      image.data.insert(image.data.end(), 3, level);
    }
  }
  return image;
}

TEST(Superpixels, KeepsLargeOnesAndNumbersThem) {
  const RgbImage image = MakeStripes();
  const auto labels = FindLargeSuperpixels(image, /*min_area=*/1500);
  ASSERT_EQ(labels.size(), 120 * 50);
  for (int row = 5; row < 45; ++row) {
    EXPECT_EQ(labels[row * 120 + 8], -1);
    EXPECT_EQ(labels[row * 120 + 40], 0);
    EXPECT_EQ(labels[row * 120 + 90], 1);
  }
}

TEST(Superpixels, AreaIsInclusive) {
  const RgbImage image{40, 30, std::vector<uint8_t>(3 * 40 * 30, 100)};
  EXPECT_THAT(FindLargeSuperpixels(image, 1200), Each(0));
  EXPECT_THAT(FindLargeSuperpixels(image, 1201), Each(-1));
}

TEST(Superpixels, HandlesOnePixel) {
  const RgbImage image{1, 1, {1, 2, 3}};
  EXPECT_THAT(FindLargeSuperpixels(image, 1), Each(0));
}

}  // namespace
}  // namespace structnerf
