#include "nerf/scene_frame.h"

#include "nerf/util/random.h"
#include "tests/nerf/plane_scene.h"

#include <functional>
#include <stdexcept>
#include <vector>

#include <Eigen/Geometry>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace structnerf {
namespace {

using testing::HasSubstr;

// Two cameras at the end of a room of 4 x 2 x 6 that is full of points, the
// first of which every camera sees.
Scene MakeRoom(const int num_points) {
  Scene scene;
  const PinholeCamera camera = MakeCamera(40, 30, 30);
  scene.views = {MakeView("a", camera, {-0.5, 0, -1}),
                 MakeView("b", camera, {0.5, 0, -1})};
  for (View& view : scene.views) {
    view.image = PlainImage(40, 30, 0);
  }
  Random random(1);
  for (int i = 0; i < num_points; ++i) {
    const Eigen::Vector3d xyz(4 * random.NextFloat() - 2,
                              2 * random.NextFloat() - 1,
                              6 * random.NextFloat() + 1);
    scene.points.push_back(MakePoint(scene, xyz, {0, 1}));
  }
  return scene;
}

// x -> scale * x + offset of the world.
Scene Moved(Scene scene, const double scale, const Eigen::Vector3d& offset) {
  for (View& view : scene.views) {
    const Eigen::Vector3d center = scale * view.ProjectionCenter() + offset;
    view.cam_from_world_translation = -(view.cam_from_world_rotation * center);
  }
  for (SparsePoint& point : scene.points) {
    point.xyz = scale * point.xyz + offset;
  }
  return scene;
}

void ExpectSameInFieldCoordinates(const Scene& scene,
                                  const SceneFrame& frame,
                                  const Scene& other_scene,
                                  const SceneFrame& other_frame,
                                  const double tolerance) {
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(frame.extent[axis], other_frame.extent[axis], tolerance);
  }
  EXPECT_NEAR(frame.near, other_frame.near, tolerance * frame.near);
  EXPECT_NEAR(frame.median_depth,
              other_frame.median_depth,
              tolerance * frame.median_depth);
  for (size_t i = 0; i < scene.points.size(); ++i) {
    EXPECT_LT((frame.FieldFromWorld(scene.points[i].xyz) -
               other_frame.FieldFromWorld(other_scene.points[i].xyz))
                  .norm(),
              tolerance);
  }
}

void ExpectError(const Scene& scene, const std::string& matter) {
  try {
    ComputeSceneFrame(scene);
    ADD_FAILURE() << "nothing was thrown";
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(), HasSubstr(matter));
  }
}

TEST(ComputeSceneFrame, HoldsCamerasAndPoints) {
  const Scene scene = MakeRoom(2000);
  const SceneFrame frame = ComputeSceneFrame(scene);
  const auto is_inside = [&](const Eigen::Vector3d& x_in_world) {
    const Eigen::Vector3d x = frame.FieldFromWorld(x_in_world);
    return (x.array() >= 0).all() &&
           (x.array() <= frame.extent.cast<double>().array()).all();
  };
  for (const View& view : scene.views) {
    EXPECT_TRUE(is_inside(view.ProjectionCenter()));
  }
  for (const SparsePoint& point : scene.points) {
    EXPECT_TRUE(is_inside(point.xyz));
  }
  // z is the longest side, from -1 to 7, widened by 15 % at both ends.
  EXPECT_NEAR(frame.extent.maxCoeff(), 1, 1e-6);
  EXPECT_NEAR(frame.extent.z(), 1, 1e-6);
  EXPECT_NEAR(1 / frame.scale, 8 * 1.3, 0.2);
  EXPECT_NEAR(frame.extent.x() / frame.scale, 4 + 2 * 0.15 * 8, 0.2);
  EXPECT_NEAR(frame.extent.y() / frame.scale, 2 + 2 * 0.15 * 8, 0.2);
  // Depths are uniform from 2 to 8.
  EXPECT_NEAR(frame.median_depth / frame.scale, 5, 0.2);
  EXPECT_NEAR(frame.near / frame.scale, 0.3 * 2.06, 0.05);
}

TEST(ComputeSceneFrame, DoesNotDependOnScaleOrPlace) {
  const Scene scene = MakeRoom(300);
  const SceneFrame frame = ComputeSceneFrame(scene);
  for (const double scale : {1e-6, 1e-3, 1e3, 1e6}) {
    SCOPED_TRACE(scale);
    const Scene moved = Moved(scene, scale, {0, 0, 0});
    ExpectSameInFieldCoordinates(
        scene, frame, moved, ComputeSceneFrame(moved), 1e-6);
  }
  // Geo-referenced: the details are a billionth of the offset.
  const Scene moved = Moved(scene, 1, {4.5e6, -1e7, 1e7});
  ExpectSameInFieldCoordinates(
      scene, frame, moved, ComputeSceneFrame(moved), 1e-6);
}

TEST(ComputeSceneFrame, OutliersDoNotBlowUpTheBox) {
  for (const int num_points : {20, 200, 2000}) {
    for (const double outlier_share : {0.01, 0.05, 0.1}) {
      SCOPED_TRACE(std::to_string(num_points) + " points, " +
                   std::to_string(outlier_share) + " wrong");
      Scene scene = MakeRoom(num_points);
      const SceneFrame expected = ComputeSceneFrame(scene);
      const int num_outliers =
          std::max(1, static_cast<int>(outlier_share * num_points));
      for (int i = 0; i < num_outliers; ++i) {
        // All to the same side, one in a thousand times the scene's size.
        scene.points.push_back(MakePoint(scene, {1e4 + i, -2e3, 5e3}, {0, 1}));
      }
      const SceneFrame frame = ComputeSceneFrame(scene);
      EXPECT_GT(frame.scale, 0.3 * expected.scale);
      EXPECT_NEAR(frame.median_depth / frame.scale,
                  expected.median_depth / expected.scale,
                  0.2 * expected.median_depth / expected.scale);
    }
  }
}

// Most points lie on one flat wall; the few in front of it are no outliers.
TEST(ComputeSceneFrame, FlatSceneKeepsWhatStandsInFront) {
  Scene scene = MakeRoom(0);
  Random random(2);
  for (int i = 0; i < 100; ++i) {
    const double depth = i < 80 ? 5.0 : 3.0;
    scene.points.push_back(MakePoint(
        scene,
        {4.0 * random.NextFloat() - 2, 2.0 * random.NextFloat() - 1, depth},
        {0, 1}));
  }
  const SceneFrame frame = ComputeSceneFrame(scene);
  for (const SparsePoint& point : scene.points) {
    const Eigen::Vector3d x = frame.FieldFromWorld(point.xyz);
    EXPECT_TRUE((x.array() >= 0).all());
    EXPECT_TRUE((x.array() <= frame.extent.cast<double>().array()).all());
  }
}

TEST(ComputeSceneFrame, PointsBehindTheirCamerasAreIgnored) {
  Scene scene = MakeRoom(300);
  const SceneFrame expected = ComputeSceneFrame(scene);
  for (int i = 0; i < 100; ++i) {
    SparsePoint point;
    point.xyz = {0, 0, -50.0 - i};
    point.track = {{0, {20, 15}}, {1, {20, 15}}};
    scene.points.push_back(point);
  }
  const SceneFrame frame = ComputeSceneFrame(scene);
  EXPECT_EQ(frame.scale, expected.scale);
  EXPECT_EQ(frame.origin, expected.origin);
  EXPECT_EQ(frame.near, expected.near);
}

TEST(ComputeSceneFrame, PointsWithoutTrackAreIgnored) {
  Scene scene = MakeRoom(300);
  const SceneFrame expected = ComputeSceneFrame(scene);
  for (int i = 0; i < 100; ++i) {
    SparsePoint point;
    point.xyz = {0, 0, 50.0 + i};
    scene.points.push_back(point);
  }
  EXPECT_EQ(ComputeSceneFrame(scene).scale, expected.scale);
}

// A wall seen head-on by cameras in its plane's parallel: no side of the box
// may vanish.
TEST(ComputeSceneFrame, FlatSceneHasABox) {
  Scene scene = MakeRoom(0);
  for (int i = 0; i < 50; ++i) {
    scene.points.push_back(MakePoint(scene, {0.2 * i - 5, 0, 5}, {0, 1}));
  }
  const SceneFrame frame = ComputeSceneFrame(scene);
  EXPECT_GT(frame.extent.minCoeff(), 0.1f);
  EXPECT_NEAR(frame.extent.maxCoeff(), 1, 1e-6);
}

TEST(ComputeSceneFrame, OnePoint) {
  Scene scene = MakeRoom(1);
  const SceneFrame frame = ComputeSceneFrame(scene);
  EXPECT_GT(frame.near, 0);
  EXPECT_LT(frame.near, frame.median_depth);
}

TEST(ComputeSceneFrame, FewerThanTwoViews) {
  ExpectError(Scene(), "fewer than two registered images");
  Scene scene = MakeRoom(1);
  scene.views.resize(1);
  scene.points[0].track.resize(1);
  ExpectError(scene, "fewer than two registered images");
}

TEST(ComputeSceneFrame, NoUsablePoints) {
  ExpectError(MakeRoom(0), "no points in front");
  Scene scene = MakeRoom(3);
  for (SparsePoint& point : scene.points) {
    point.track.clear();
  }
  ExpectError(scene, "no points in front");
}

TEST(ComputeSceneFrame, AllInOnePlace) {
  Scene scene = MakeRoom(0);
  for (View& view : scene.views) {
    view = MakeView(view.name, view.camera, {1, 2, 3});
  }
  // In front of its camera by less than double can tell.
  SparsePoint point = MakePoint(scene, {1, 2, 3}, {0, 1});
  scene.points = {point};
  EXPECT_THROW(ComputeSceneFrame(scene), std::invalid_argument);
}

TEST(DepthInView, IsZInTheCameraFrame) {
  const View view =
      MakeView("", MakeCamera(4, 3, 5), {1e7, -1e7, 3e6}, {1, 0.5, -2});
  const Eigen::Vector3d direction = Eigen::Vector3d(1, 0.5, -2).normalized();
  const Eigen::Vector3d sideways =
      direction.cross(Eigen::Vector3d::UnitX()).normalized();
  const Eigen::Vector3d x =
      view.ProjectionCenter() + 3.25 * direction + 7 * sideways;
  EXPECT_NEAR(DepthInView(view, x), 3.25, 1e-7);
}

}  // namespace
}  // namespace structnerf
