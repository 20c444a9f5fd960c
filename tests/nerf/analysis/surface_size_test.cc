#include "nerf/analysis/surface_size.h"

#include "tests/nerf/plane_scene.h"

#include <gtest/gtest.h>

namespace structnerf {
namespace {

// Two cameras in front of a wall at z = 4 that fills their images, 4.8 x 3.6,
// in a box of 10 units.
class SurfaceSizeTest : public testing::Test {
 protected:
  SurfaceSizeTest() {
    const PinholeCamera camera = MakeCamera(640, 480, 533.33);
    scene_.views = {MakeView("a", camera, {0, 0, 0}),
                    MakeView("b", camera, {0.01, 0, 0})};
    for (double y = -1.7; y < 1.75; y += 0.2) {
      for (double x = -2.3; x < 2.35; x += 0.2) {
        scene_.points.push_back(MakePoint(scene_, {x, y, 4}, {0, 1}));
      }
    }
    frame_.origin = {-5, -5, -5};
    frame_.scale = 0.1;
    frame_.extent = {1, 1, 1};
  }

  Scene scene_;
  SceneFrame frame_;
};

TEST_F(SurfaceSizeTest, CountsTheCellsOfAWall) {
  // 0.48 x 0.36 of the box's sides.
  const double expected = 0.48 * 320 * 0.36 * 320;
  EXPECT_NEAR(
      CountSurfaceCells(scene_, frame_, 320), expected, 0.25 * expected);
}

TEST_F(SurfaceSizeTest, GrowsWithTheSquareOfTheResolution) {
  EXPECT_DOUBLE_EQ(CountSurfaceCells(scene_, frame_, 640),
                   4 * CountSurfaceCells(scene_, frame_, 320));
}

TEST_F(SurfaceSizeTest, PhotographsMakeNoDifference) {
  const double without = CountSurfaceCells(scene_, frame_, 320);
  for (View& view : scene_.views) {
    view.image = PlainImage(160, 120, 77);
  }
  EXPECT_NEAR(CountSurfaceCells(scene_, frame_, 320), without, 0.05 * without);
}

TEST_F(SurfaceSizeTest, MorePlacesAreMoreCells) {
  const double one_wall = CountSurfaceCells(scene_, frame_, 320);
  // The other way.
  scene_.views.push_back(
      MakeView("c", scene_.views[0].camera, {0, 0, 0}, {0, 0, -1}));
  for (double x = -2.3; x < 2.35; x += 0.2) {
    scene_.points.push_back(MakePoint(scene_, {x, 0, -4}, {2}));
  }
  EXPECT_NEAR(
      CountSurfaceCells(scene_, frame_, 320), 2 * one_wall, 0.2 * one_wall);
}

TEST_F(SurfaceSizeTest, WhatLiesOutsideTheBoxDoesNotCount) {
  frame_.extent = {1, 1, 0.8f};
  EXPECT_EQ(CountSurfaceCells(scene_, frame_, 320), 0);
}

TEST_F(SurfaceSizeTest, WithoutPointsThereIsNone) {
  scene_.points.clear();
  EXPECT_EQ(CountSurfaceCells(scene_, frame_, 320), 0);
}

}  // namespace
}  // namespace structnerf
