#include "nerf/scene.h"

#include "tests/nerf/plane_scene.h"

#include <functional>
#include <limits>
#include <stdexcept>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace structnerf {
namespace {

using testing::HasSubstr;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

Scene MakeValidScene() {
  Scene scene;
  const PinholeCamera camera = MakeCamera(40, 30, 50);
  scene.views = {MakeView("hall/first.jpg", camera, {0, 0, 0}),
                 MakeView("hall/second.jpg", camera, {1, 0, 0})};
  for (View& view : scene.views) {
    view.image = PlainImage(20, 15, 128);
    view.mask.assign(300, 255);
    view.segments.assign(300, -1);
  }
  scene.points = {MakePoint(scene, {0, 0, 4}, {0, 1})};
  return scene;
}

// Expects Check() to refuse a valid scene after a change, naming the place and
// the matter.
void ExpectRefused(const std::function<void(Scene*)>& change,
                   const std::string& place,
                   const std::string& matter) {
  SCOPED_TRACE(matter);
  Scene scene = MakeValidScene();
  change(&scene);
  try {
    scene.Check();
    ADD_FAILURE() << "nothing was thrown";
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(), HasSubstr(place));
    EXPECT_THAT(error.what(), HasSubstr(matter));
  }
}

TEST(Scene, ValidScenesPass) {
  EXPECT_NO_THROW(MakeValidScene().Check());
  Scene scene = MakeValidScene();
  for (View& view : scene.views) {
    view.mask.clear();
    view.segments.clear();
  }
  scene.points[0].error = -1;
  EXPECT_NO_THROW(scene.Check());
  EXPECT_NO_THROW(Scene().Check());
}

TEST(Scene, WrongViewsAreNamed) {
  const auto expect = [](const std::function<void(View*)>& change,
                         const std::string& matter) {
    ExpectRefused([&](Scene* scene) { change(&scene->views[1]); },
                  "hall/second.jpg",
                  matter);
  };
  expect([](View* v) { v->camera.width = 0; }, "camera has no size");
  expect([](View* v) { v->camera.height = -3; }, "camera has no size");
  expect([](View* v) { v->camera.fx = 0; }, "focal length");
  expect([](View* v) { v->camera.fy = -50; }, "focal length");
  expect([](View* v) { v->camera.fx = kNan; }, "focal length");
  expect([](View* v) { v->camera.cy = kNan; }, "principal point");
  expect([](View* v) { v->cam_from_world_rotation(1, 2) = kNan; }, "pose");
  expect([](View* v) { v->cam_from_world_translation.x() = kNan; }, "pose");
  expect([](View* v) { v->cam_from_world_rotation *= 1.001; }, "rotation");
  expect([](View* v) { v->cam_from_world_rotation.col(0).setZero(); },
         "rotation");
  // A mirror keeps lengths and angles, but left becomes right.
  expect([](View* v) { v->cam_from_world_rotation.row(0) *= -1; }, "rotation");
  expect([](View* v) { v->image = RgbImage(); }, "image is empty");
  expect([](View* v) { v->image = PlainImage(41, 30, 0); }, "larger");
  expect([](View* v) { v->image = PlainImage(40, 31, 0); }, "larger");
  expect([](View* v) { v->image.data.pop_back(); }, "image data");
  expect([](View* v) { v->mask.pop_back(); }, "mask");
  expect([](View* v) { v->segments.push_back(0); }, "segments");
  expect([](View* v) { v->segments[7] = 300; }, "label");
  expect([](View* v) { v->segments[7] = -2; }, "label");
}

TEST(Scene, WrongPointsAreNamed) {
  const auto expect = [](const std::function<void(SparsePoint*)>& change,
                         const std::string& matter) {
    ExpectRefused(
        [&](Scene* scene) {
          scene->points.push_back(scene->points[0]);
          change(&scene->points[1]);
        },
        "sparse point 1",
        matter);
  };
  expect([](SparsePoint* p) { p->xyz.z() = kNan; }, "position");
  expect([](SparsePoint* p) { p->track[0].view_idx = 2; }, "view");
  expect([](SparsePoint* p) { p->track[1].view_idx = -1; }, "view");
  expect([](SparsePoint* p) { p->track[1].xy.y() = kNan; }, "observation");
  expect([](SparsePoint* p) { p->error = kNan; }, "error");
  expect(
      [](SparsePoint* p) {
        p->error = std::numeric_limits<double>::infinity();
      },
      "error");
}

TEST(PinholeCamera, ReducedIsNeverEnlargedAndNeverEmpty) {
  const PinholeCamera camera = MakeCamera(40, 30, 50);
  EXPECT_EQ(camera.NumPixels(), 1200);
  EXPECT_EQ(camera.Reduced(40).width, 40);
  EXPECT_EQ(camera.Reduced(1000).fx, camera.fx);
  const PinholeCamera half = camera.Reduced(20);
  EXPECT_EQ(half.width, 20);
  EXPECT_EQ(half.height, 15);
  EXPECT_DOUBLE_EQ(half.fx, 25);
  // The longer side counts, whichever it is.
  EXPECT_EQ(MakeCamera(30, 40, 50).Reduced(20).width, 15);
  EXPECT_EQ(MakeCamera(1000, 1, 50).Reduced(10).height, 1);
}

TEST(PinholeCamera, ResizedKeepsTheFieldOfView) {
  const PinholeCamera camera{40, 30, 50, 55, 19, 16};
  const PinholeCamera half = camera.Resized(20, 10);
  EXPECT_EQ(half.width, 20);
  EXPECT_EQ(half.height, 10);
  EXPECT_DOUBLE_EQ(half.fx, 25);
  EXPECT_DOUBLE_EQ(half.fy, 55 / 3.0);
  EXPECT_DOUBLE_EQ(half.cx, 9.5);
  EXPECT_DOUBLE_EQ(half.cy, 16 / 3.0);
  // The same ray goes through the same place of both images.
  const double ray_x = (40 - camera.cx) / camera.fx;
  EXPECT_DOUBLE_EQ(half.fx * ray_x + half.cx, 20);
}

TEST(View, ProjectionCenter) {
  const Eigen::Vector3d center(1, -2, 3);
  const View view = MakeView("", MakeCamera(4, 3, 5), center, {0.3, 0.2, 0.9});
  EXPECT_LT((view.ProjectionCenter() - center).norm(), 1e-12);
}

TEST(View, CamFromWorldAndBack) {
  // Looks along the world's x.
  View view;
  view.cam_from_world_rotation << 0, 0, -1, 0, 1, 0, 1, 0, 0;
  view.cam_from_world_translation = {0.5, -1, 2};
  const Eigen::Vector3d in_world(3, 4, -7);
  const Eigen::Vector3d in_view(7.5, 3, 5);
  EXPECT_EQ(view.CamFromWorld(in_world), in_view);
  EXPECT_EQ(view.WorldFromCam(in_view), in_world);
  EXPECT_EQ(view.CamFromWorld(view.ProjectionCenter()),
            Eigen::Vector3d(0, 0, 0));
}

TEST(Scene, PriorsHaveTheSizeOfTheImage) {
  Scene scene = MakeValidScene();
  scene.views[1].prior_depth.assign(300, 2);
  scene.views[1].prior_depth[7] = 0;
  EXPECT_NO_THROW(scene.Check());
  scene.views[1].prior_deviation.assign(300, 0.1f);
  EXPECT_NO_THROW(scene.Check());
  const std::string name = "hall/second.jpg";
  ExpectRefused([](Scene* s) { s->views[1].prior_depth.assign(299, 2); },
                name,
                "depth prior");
  ExpectRefused([](Scene* s) { s->views[1].prior_deviation.assign(300, 2); },
                name,
                "depth prior");
  ExpectRefused([](Scene* s) { s->views[1].prior_depth.assign(300, -1); },
                name,
                "depth prior");
  ExpectRefused([](Scene* s) { s->views[1].near_depth.assign(300, 1); },
                name,
                "bounds of depth");
  ExpectRefused(
      [](Scene* s) { s->views[1].exposure.gain[0] = 0; }, name, "exposure");
  ExpectRefused([](Scene* s) { s->views[1].exposure.offset[2] = kNan; },
                name,
                "exposure");
}

}  // namespace
}  // namespace structnerf
