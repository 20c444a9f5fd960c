#include "colmap_plugin/rendering/novel_path.h"

#include "tests/nerf/plane_scene.h"
#include "tests/support/temp_dir.h"

#include <cmath>
#include <fstream>

#include <Eigen/Geometry>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace structnerf {
namespace {

using testing::HasSubstr;

const PinholeCamera kCamera = MakeCamera(64, 48, 60);

TEST(InterpolateViewsTest, PassesThroughTheViews) {
  const std::vector<View> views = {
      MakeView("a", kCamera, {0, 0, 0}, {0, 0, 1}),
      MakeView("b", kCamera, {1, 0, 0}, {1, 0, 1}),
      MakeView("c", kCamera, {1, 2, 0}, {1, 0, 0})};
  const std::vector<View> path = InterpolateViews(views, kCamera, 5);
  ASSERT_EQ(path.size(), 5);
  for (int i = 0; i < 3; ++i) {
    EXPECT_TRUE(path[2 * i].cam_from_world_rotation.isApprox(
        views[i].cam_from_world_rotation, 1e-9));
    EXPECT_TRUE(path[2 * i].ProjectionCenter().isApprox(
        views[i].ProjectionCenter(), 1e-9));
  }
  EXPECT_EQ(path[3].name, "frame_0003");
  EXPECT_TRUE(
      path[1].ProjectionCenter().isApprox(Eigen::Vector3d(0.5, 0, 0), 1e-9));
  // Half way between two directions that are 45 degrees apart.
  const double angle = M_PI / 8;
  EXPECT_TRUE(path[1].cam_from_world_rotation.row(2).transpose().isApprox(
      Eigen::Vector3d(std::sin(angle), 0, std::cos(angle)), 1e-9));
}

TEST(InterpolateViewsTest, RefusesWhatIsNoPath) {
  const View view = MakeView("a", kCamera, {0, 0, 0});
  EXPECT_THROW(InterpolateViews({view}, kCamera, 5), std::invalid_argument);
  EXPECT_THROW(InterpolateViews({view, view}, kCamera, 1),
               std::invalid_argument);
}

TEST(OrbitViewTest, LooksAtOnePointFromACircle) {
  const View view = MakeView("a", kCamera, {1, 2, 3}, {0.3, 0.1, 1});
  const double depth = 5;
  const Eigen::Vector3d target =
      view.ProjectionCenter() +
      depth * view.cam_from_world_rotation.row(2).transpose();
  const std::vector<View> path = OrbitView(view, depth, 0.5, 12);
  ASSERT_EQ(path.size(), 12);
  for (const View& frame : path) {
    EXPECT_NEAR(
        (frame.ProjectionCenter() - view.ProjectionCenter()).norm(), 0.5, 1e-9);
    const Eigen::Vector3d projected = Project(frame, target);
    EXPECT_NEAR(projected.x(), kCamera.cx, 1e-9);
    EXPECT_NEAR(projected.y(), kCamera.cy, 1e-9);
    EXPECT_GT(projected.z(), 0);
    EXPECT_NEAR(frame.cam_from_world_rotation.determinant(), 1, 1e-9);
    // Upright as the view is.
    EXPECT_GT(frame.cam_from_world_rotation.row(1).dot(
                  view.cam_from_world_rotation.row(1)),
              0.95);
  }
}

TEST(ReadPosesTest, ReadsNamesAndPoses) {
  const TempDir temp_dir;
  std::ofstream(temp_dir / "poses.txt") << "# comment\n\n"
                                           "left 1 0 0 0 1 2 3\n"
                                           "right 0 0 1 0 0 0 -1\r\n";
  const std::vector<View> views = ReadPoses(temp_dir / "poses.txt", kCamera);
  ASSERT_EQ(views.size(), 2);
  EXPECT_EQ(views[0].name, "left");
  EXPECT_EQ(views[0].cam_from_world_translation, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(views[0].camera.width, 64);
  // Half a turn about y.
  EXPECT_TRUE(views[1].cam_from_world_rotation.isApprox(
      Eigen::Vector3d(-1, 1, -1).asDiagonal().toDenseMatrix(), 1e-9));
}

TEST(ReadPosesTest, NamesTheLineThatIsWrong) {
  const TempDir temp_dir;
  const std::string path = temp_dir / "poses.txt";
  for (const char* line : {"a 1 0 0 0 1 2",
                           "a 1 0 0 0 1 2 3 4",
                           "a 1 1 0 0 1 2 3",
                           "a one 0 0 0 1 2 3"}) {
    std::ofstream(path) << "# poses\n" << line << "\n";
    try {
      ReadPoses(path, kCamera);
      ADD_FAILURE() << line;
    } catch (const std::runtime_error& error) {
      EXPECT_THAT(error.what(), HasSubstr("Line 2 of " + path));
    }
  }
  std::ofstream(path) << "a 1 0 0 0 1 2 3\na 1 0 0 0 3 2 1\n";
  try {
    ReadPoses(path, kCamera);
    ADD_FAILURE();
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr("Line 2 of " + path + " repeats"));
  }
  std::ofstream(path) << "# none\n";
  EXPECT_THROW(ReadPoses(path, kCamera), std::runtime_error);
  EXPECT_THROW(ReadPoses(temp_dir / "missing", kCamera), std::runtime_error);
}

TEST(MedianPointDepthTest, IsThatOfTheObservedPoints) {
  Scene scene;
  scene.views = {MakeView("a", kCamera, {0, 0, 0}),
                 MakeView("b", kCamera, {0, 0, 1})};
  for (const double z : {2.0, 3.0, 7.0}) {
    scene.points.push_back(MakePoint(scene, {0, 0, z}, {0}));
  }
  scene.points.push_back(MakePoint(scene, {0, 0, 9}, {1}));
  EXPECT_DOUBLE_EQ(MedianPointDepth(scene, 0), 3);
  EXPECT_DOUBLE_EQ(MedianPointDepth(scene, 1), 8);
  scene.points.pop_back();
  EXPECT_DOUBLE_EQ(MedianPointDepth(scene, 1), 2);  // observes none
  scene.points.clear();
  EXPECT_THROW(MedianPointDepth(scene, 0), std::invalid_argument);
}

}  // namespace
}  // namespace structnerf
