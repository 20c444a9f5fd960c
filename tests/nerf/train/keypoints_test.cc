#include "nerf/train/keypoints.h"

#include "nerf/scene_frame.h"
#include "tests/nerf/plane_scene.h"

#include <cmath>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace structnerf {
namespace {

using testing::Contains;
using testing::IsEmpty;

constexpr int kWidth = 64;
constexpr int kHeight = 40;

// Two views of a grey wall in front of which two points are.
Scene GrayScene() {
  Scene scene;
  for (const double x : {0.0, 0.5}) {
    scene.views.push_back(
        MakeView("view", MakeCamera(kWidth, kHeight, 50), {x, 0, 0}));
    scene.views.back().image = {
        kWidth, kHeight, std::vector<uint8_t>(3 * kWidth * kHeight, 100)};
  }
  scene.points.push_back(MakePoint(scene, {0, 0, 2}, {0, 1}));
  scene.points.push_back(MakePoint(scene, {0.2, 0.1, 3}, {0, 1}));
  return scene;
}

void Paint(const int col, const int row, const int gray, Scene* scene) {
  for (int c = 0; c < 3; ++c) {
    scene->views[0].image.data[3 * (row * kWidth + col) + c] =
        static_cast<uint8_t>(gray);
  }
}

std::vector<uint32_t> Keypoints(const Scene& scene) {
  return SelectKeypoints(TrainingViews(scene, ComputeSceneFrame(scene)), 0);
}

TEST(SelectKeypoints, BlankImagesHaveNone) {
  EXPECT_THAT(Keypoints(GrayScene()), IsEmpty());
}

TEST(SelectKeypoints, AboutOnePerCellAtAnEdge) {
  Scene scene = GrayScene();
  for (int row = 0; row < kHeight; ++row) {
    for (int col = 22; col < kWidth; ++col) {
      Paint(col, row, 160, &scene);
    }
  }
  const std::vector<uint32_t> keypoints = Keypoints(scene);
  // Columns 21 and 22 are in one cell; ten cells of four rows.
  ASSERT_EQ(keypoints.size(), 10u);
  for (const uint32_t pixel : keypoints) {
    EXPECT_THAT((std::vector<uint32_t>{21, 22}), Contains(pixel % kWidth));
  }
}

// The gradient beside a brighter pixel is half the difference.
TEST(SelectKeypoints, WeakGradientsDoNotCount) {
  for (const int difference : {10, 13, 15, 20}) {
    Scene scene = GrayScene();
    Paint(41, 21, 100 + difference, &scene);
    EXPECT_EQ(Keypoints(scene).empty(), difference < 14) << difference;
  }
}

TEST(SelectKeypoints, TheStrongestOfACell) {
  Scene scene = GrayScene();
  // Cell (40..43, 20..23): gradients of 25 around (41, 21), 75 at (42, 22).
  Paint(42, 21, 150, &scene);
  Paint(42, 23, 0, &scene);
  const std::vector<uint32_t> keypoints = Keypoints(scene);
  EXPECT_THAT(keypoints, Contains(22u * kWidth + 42));
}

// In a block that is restless all over, only what exceeds its median counts.
TEST(SelectKeypoints, ThresholdIsThatOfTheBlock) {
  Scene scene = GrayScene();
  for (int row = 0; row < kHeight; ++row) {
    for (int col = 0; col < 32; ++col) {
      Paint(col, row, 40 + 6 * col, &scene);
    }
  }
  for (const uint32_t pixel : Keypoints(scene)) {
    EXPECT_GE(pixel % kWidth, 31u);
  }
}

TEST(SelectKeypoints, NoneBesideMaskedPixels) {
  Scene scene = GrayScene();
  Paint(41, 21, 200, &scene);
  ASSERT_FALSE(Keypoints(scene).empty());
  scene.views[0].mask.assign(kWidth * kHeight, 255);
  scene.views[0].mask[21 * kWidth + 41] = 0;
  EXPECT_THAT(Keypoints(scene), IsEmpty());
}

}  // namespace
}  // namespace structnerf
