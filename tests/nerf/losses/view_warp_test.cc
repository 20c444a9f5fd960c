#include "nerf/losses/view_warp.h"

#include "tests/nerf/plane_scene.h"

#include <gtest/gtest.h>

namespace structnerf {
namespace {

// Field units per world unit.
constexpr double kScale = 0.125;

// Two views with different cameras, the source's image half its camera's size,
// at a distance from the world's origin.
Scene MakeScene(const Eigen::Vector3d& origin) {
  Scene scene;
  scene.views = {MakeView("view", {64, 48, 70, 66, 30, 25.5}, origin),
                 MakeView("source",
                          {80, 60, 90, 95, 41, 28},
                          origin + Eigen::Vector3d(0.5, -0.2, 0.3),
                          Eigen::Vector3d(-0.2, 0.1, 1))};
  scene.views[0].image = PlainImage(64, 48, 10);
  scene.views[1].image = PlainImage(40, 30, 20);
  return scene;
}

// What the warp makes of the image point (x, y) of the view at a depth in world
// units: homogeneous.
Eigen::Vector3d Warp(const ViewWarp& warp,
                     const double x,
                     const double y,
                     const double depth) {
  Eigen::Vector3d p;
  for (int i = 0; i < 3; ++i) {
    p[i] = warp.h[3 * i] * x + warp.h[3 * i + 1] * y + warp.h[3 * i + 2] +
           warp.b[i] / (kScale * depth);
  }
  return p;
}

void ExpectProjections(const Scene& scene, const double tolerance) {
  const TrainingViews views(scene, SceneFrame());
  const View& view = scene.views[0];
  const View& source = scene.views[1];
  const ViewWarp warp =
      MakeViewWarp(view, source, views.image(0), views.image(1), kScale);
  for (const double depth : {0.9, 4.0, 30.0}) {
    for (const auto& [x, y] :
         {std::pair(0.5, 0.5), {63.5, 7.0}, {20.0, 47.5}}) {
      const Eigen::Vector3d expected =
          Project(source, Unproject(view, x, y, depth));
      const Eigen::Vector3d p = Warp(warp, x, y, depth);
      // In the source's image, which is half its camera's size.
      EXPECT_NEAR(p.x() / p.z(), expected.x() / 2, tolerance);
      EXPECT_NEAR(p.y() / p.z(), expected.y() / 2, tolerance);
      EXPECT_NEAR(p.z(), expected.z() / depth, 1e-5);
    }
  }
}

TEST(ViewWarp, ProjectsIntoTheSourcesImage) {
  ExpectProjections(MakeScene(Eigen::Vector3d::Zero()), 1e-4);
}

// As in geo-referenced models. What the test itself computes is exact to 1e-7
// of a pixel there; a warp made of translations in single precision would not
// be.
TEST(ViewWarp, IsExactFarFromTheWorldsOrigin) {
  ExpectProjections(MakeScene(Eigen::Vector3d(4e5, -5e6, 300)), 1e-4);
}

TEST(ViewWarp, ToTheViewItselfIsNoMotion) {
  const Scene scene = MakeScene(Eigen::Vector3d(1, 2, 3));
  const TrainingViews views(scene, SceneFrame());
  const ViewWarp warp = MakeViewWarp(
      scene.views[0], scene.views[0], views.image(0), views.image(0), kScale);
  for (int i = 0; i < 9; ++i) {
    EXPECT_NEAR(warp.h[i], i % 4 == 0 ? 1.0f : 0.0f, 1e-5f);
  }
  for (const float b : warp.b) {
    EXPECT_NEAR(b, 0.0f, 1e-6f);
  }
}

TEST(ViewWarp, NamesTheSourcesPixels) {
  const Scene scene = MakeScene(Eigen::Vector3d::Zero());
  const TrainingViews views(scene, SceneFrame());
  const ViewWarp warp = MakeViewWarp(
      scene.views[0], scene.views[1], views.image(0), views.image(1), kScale);
  EXPECT_EQ(warp.width, 40);
  EXPECT_EQ(warp.height, 30);
  EXPECT_EQ(warp.stride, 40);
  EXPECT_EQ(warp.first_pixel, 64 * 48);
}

}  // namespace
}  // namespace structnerf
