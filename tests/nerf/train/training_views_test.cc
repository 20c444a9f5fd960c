#include "nerf/train/training_views.h"

#include "nerf/util/random.h"
#include "tests/nerf/plane_scene.h"

#include <cmath>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>

namespace structnerf {
namespace {

// A box of 10 x 8 x 5 at geo-referenced coordinates, longest side 1.
SceneFrame MakeFrame() {
  SceneFrame frame;
  frame.origin = Eigen::Vector3d(4e6, -1e7, 2e6);
  frame.scale = 0.1;
  frame.extent = Eigen::Vector3f(1.0f, 0.8f, 0.5f);
  frame.near = 0.01;
  return frame;
}

View MakeTestView(const Eigen::Vector3d& position_in_box,
                  const Eigen::Vector3d& direction) {
  return MakeView("view",
                  {40, 30, 33, 35, 19, 16},
                  MakeFrame().origin + position_in_box,
                  direction);
}

Eigen::Vector3d Origin(const RayTile& rays, const int ray) {
  return {rays.origin[0][ray], rays.origin[1][ray], rays.origin[2][ray]};
}

Eigen::Vector3d Direction(const RayTile& rays, const int ray) {
  return {
      rays.direction[0][ray], rays.direction[1][ray], rays.direction[2][ray]};
}

TEST(ViewGeometry, RaysGoThroughTheirImagePointAndAreParametrisedByDepth) {
  const SceneFrame frame = MakeFrame();
  const View view = MakeTestView({4, 3, 2}, {0.3, -0.2, 1});
  const ViewGeometry geometry(view, view.camera, frame);
  Random random(1);
  RayTile rays;
  for (int ray = 0; ray < kMaxTileRays; ++ray) {
    const double x = 40 * random.NextFloat();
    const double y = 30 * random.NextFloat();
    geometry.SetRay(x, y, ray, &rays);
    for (const double depth : {0.02, 0.1, 0.4}) {
      const Eigen::Vector3d in_world =
          (Origin(rays, ray) + depth * Direction(rays, ray)) / frame.scale +
          frame.origin;
      const Eigen::Vector3d pixel = Project(view, in_world);
      EXPECT_NEAR(pixel.x(), x, 1e-3);
      EXPECT_NEAR(pixel.y(), y, 1e-3);
      EXPECT_NEAR(pixel.z() * frame.scale, depth, 1e-6);
    }
    EXPECT_NEAR(rays.direction_norm[ray], Direction(rays, ray).norm(), 1e-6);
  }
}

TEST(ViewGeometry, CameraOfAnotherSizeGivesTheSameRays) {
  const View view = MakeTestView({4, 3, 2}, {0.3, -0.2, 1});
  const ViewGeometry full(view, view.camera, MakeFrame());
  const ViewGeometry half(view, view.camera.Resized(20, 10), MakeFrame());
  RayTile rays;
  full.SetRay(30, 12, 0, &rays);
  half.SetRay(15, 4, 1, &rays);
  EXPECT_LT((Direction(rays, 0) - Direction(rays, 1)).norm(), 1e-6);
}

TEST(ViewGeometry, RaysEndWhereTheyLeaveTheBox) {
  const SceneFrame frame = MakeFrame();
  Random random(2);
  for (int round = 0; round < 200; ++round) {
    const View view = MakeTestView({1 + 8 * random.NextFloat(),
                                    1 + 6 * random.NextFloat(),
                                    1 + 3 * random.NextFloat()},
                                   {random.NextFloat() - 0.5,
                                    random.NextFloat() - 0.5,
                                    random.NextFloat() - 0.5});
    RayTile rays;
    ViewGeometry(view, view.camera, frame).SetRay(20, 10, 0, &rays);
    EXPECT_NEAR(rays.near[0], 0.01, 1e-7);
    ASSERT_GT(rays.far[0], rays.near[0]);
    const Eigen::Vector3d end =
        Origin(rays, 0) + rays.far[0] * Direction(rays, 0);
    const Eigen::Vector3d extent = frame.extent.cast<double>();
    double to_wall = 1;
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_GT(end[axis], -1e-5);
      EXPECT_LT(end[axis], extent[axis] + 1e-5);
      to_wall = std::min(
          to_wall, std::min(std::abs(end[axis]), extent[axis] - end[axis]));
    }
    EXPECT_NEAR(to_wall, 0, 1e-5);
  }
}

// From a corner of the box, outwards and along a side.
TEST(ViewGeometry, RaysAreNeverEmpty) {
  const SceneFrame frame = MakeFrame();
  for (const Eigen::Vector3d& direction :
       std::vector<Eigen::Vector3d>{{-1, -1, -1}, {0, 0, -1}, {0, 0, 1}}) {
    View view = MakeTestView({1e-4, 1e-4, 1e-4}, direction);
    RayTile rays;
    ViewGeometry(view, view.camera, frame).SetRay(19, 16, 0, &rays);
    EXPECT_GT(rays.far[0], rays.near[0]);
    EXPECT_TRUE(std::isfinite(rays.far[0]));
  }
}

TEST(TrainingViews, ColorsGraysAndMasks) {
  Scene scene;
  scene.views = {MakeTestView({1, 1, 1}, {0, 0, 1}),
                 MakeTestView({2, 1, 1}, {0, 0, 1})};
  scene.views[0].image = PlainImage(3, 2, 0);
  scene.views[1].image = PlainImage(4, 5, 255);
  RgbImage& image = scene.views[1].image;
  const size_t pixel = 3 * 4 + 2;  // row 3, column 2
  image.data[3 * pixel] = 51;
  image.data[3 * pixel + 1] = 102;
  image.data[3 * pixel + 2] = 204;
  scene.views[1].mask.assign(20, 255);
  scene.views[1].mask[7] = 0;  // row 1, column 3
  const TrainingViews views(scene, MakeFrame());
  ASSERT_EQ(views.size(), 2u);
  EXPECT_EQ(views.image(0).width, 3);
  EXPECT_EQ(views.image(1).height, 5);
  EXPECT_LT((views.Color(1, 2, 3) - Eigen::Vector3f(0.2f, 0.4f, 0.8f)).norm(),
            1e-6);
  EXPECT_EQ(views.Color(0, 2, 1), Eigen::Vector3f::Zero());
  EXPECT_EQ(views.Color(1, 0, 0), Eigen::Vector3f::Ones());

  const uint16_t* const grays = views.Grays() + views.image(1).first_pixel;
  EXPECT_EQ(views.Grays()[views.image(0).first_pixel], 0);
  // White is not mistaken for a mask.
  EXPECT_EQ(grays[0], TrainingViews::kMaxGray);
  EXPECT_FALSE(views.IsMasked(1, 0, 0));
  const double luma = 0.299 * 0.2 + 0.587 * 0.4 + 0.114 * 0.8;
  EXPECT_NEAR(grays[pixel], luma * TrainingViews::kMaxGray, 1);
  EXPECT_EQ(grays[7], TrainingViews::kMaskedGray);
  int num_masked = 0;
  for (int row = 0; row < 5; ++row) {
    for (int col = 0; col < 4; ++col) {
      num_masked += views.IsMasked(1, col, row);
    }
  }
  EXPECT_EQ(num_masked, 1);
  EXPECT_TRUE(views.IsMasked(1, 3, 1));
}

TEST(TrainingViews, MorePixelsThanCanBeAddressedAreRefused) {
  Scene scene;
  scene.views = {MakeTestView({1, 1, 1}, {0, 0, 1}),
                 MakeTestView({2, 1, 1}, {0, 0, 1})};
  for (View& view : scene.views) {
    // Only the sizes count; nothing must be read or allocated.
    view.image.width = 32768;
    view.image.height = 16384;
  }
  EXPECT_THROW(TrainingViews(scene, MakeFrame()), std::invalid_argument);
}

}  // namespace
}  // namespace structnerf
