#include "nerf/analysis/point_colors.h"

#include "tests/nerf/plane_scene.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

namespace structnerf {
namespace {

constexpr int kWidth = 64;
constexpr int kHeight = 48;

// Three photographs of 35 points on a wall, each of one grey.
Scene GreyScene(const std::array<uint8_t, 3>& greys) {
  Scene scene;
  const PinholeCamera camera = MakeCamera(2 * kWidth, 2 * kHeight, 100);
  for (int v = 0; v < 3; ++v) {
    scene.views.push_back(MakeView("view", camera, {0.1 * v, 0, 0}));
    scene.views.back().image = PlainImage(kWidth, kHeight, greys[v]);
  }
  for (double y = -0.8; y < 0.9; y += 0.4) {
    for (double x = -0.9; x < 1; x += 0.3) {
      scene.points.push_back(MakePoint(scene, {x, y, 4}, {0, 1, 2}));
    }
  }
  return scene;
}

TEST(CollectPointColors, TakesEveryPhotographOfAPoint) {
  const Scene scene = GreyScene({51, 102, 153});
  const std::vector<PointColor> colors = CollectPointColors(scene);
  ASSERT_EQ(colors.size(), 3 * scene.points.size());
  for (size_t i = 0; i < colors.size(); ++i) {
    EXPECT_EQ(colors[i].point_idx, i / 3);
    EXPECT_EQ(colors[i].view_idx, i % 3);
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(colors[i].color[c], 0.2 * (1 + i % 3), 1e-6);
    }
  }
}

TEST(CollectPointColors, InterpolatesBetweenPixels) {
  Scene scene = GreyScene({100, 100, 100});
  // Brighter by one grey level from column to column.
  RgbImage& image = scene.views[0].image;
  for (int row = 0; row < kHeight; ++row) {
    for (int col = 0; col < kWidth; ++col) {
      std::fill_n(&image.data[3 * (row * kWidth + col)], 3, 50 + col);
    }
  }
  for (const PointColor& color : CollectPointColors(scene)) {
    if (color.view_idx == 0) {
      // The camera's image is twice as large.
      const double x = scene.points[color.point_idx].track[0].xy.x() / 2 - 0.5;
      EXPECT_NEAR(255 * color.color.x(), 50 + x, 1e-3);
    }
  }
}

TEST(CollectPointColors, LeavesOutWhatSaysNothing) {
  EXPECT_EQ(CollectPointColors(GreyScene({2, 100, 100})).size(), 70);
  EXPECT_EQ(CollectPointColors(GreyScene({100, 100, 254})).size(), 70);
  // Of one photograph alone.
  EXPECT_TRUE(CollectPointColors(GreyScene({2, 100, 254})).empty());
  Scene scene = GreyScene({100, 100, 100});
  scene.views[1].mask.assign(kWidth * kHeight, 0);
  for (const PointColor& color : CollectPointColors(scene)) {
    EXPECT_NE(color.view_idx, 1);
  }
}

TEST(CollectPointColors, ThinsOutManyPoints) {
  Scene scene = GreyScene({100, 100, 100});
  const std::vector<SparsePoint> points = scene.points;
  for (int i = 0; i < 1000; ++i) {
    scene.points.insert(scene.points.end(), points.begin(), points.end());
  }
  const size_t num_colors = CollectPointColors(scene).size();
  EXPECT_LE(num_colors, 30000);
  EXPECT_GT(num_colors, 15000);
}

TEST(MeasureColorSpread, IsTheMedianDifferenceFromTheMean) {
  EXPECT_NEAR(MeasureColorSpread(GreyScene({100, 100, 100})), 0, 1e-6);
  // 0, 10 and -10 of 255.
  EXPECT_NEAR(MeasureColorSpread(GreyScene({110, 120, 100})), 10 / 255.0, 1e-6);
}

TEST(MeasureColorSpread, DoesNotCountExposure) {
  Scene scene = GreyScene({80, 100, 120});
  for (int v = 0; v < 3; ++v) {
    scene.views[v].exposure.gain.setConstant(0.8f + 0.2f * v);
  }
  EXPECT_NEAR(MeasureColorSpread(scene), 0, 1e-6);
}

TEST(MeasureColorSpread, IsZeroWithoutColors) {
  Scene scene = GreyScene({100, 100, 100});
  scene.points.clear();
  EXPECT_EQ(MeasureColorSpread(scene), 0);
}

}  // namespace
}  // namespace structnerf
