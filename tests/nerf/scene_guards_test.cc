#include "nerf/scene_guards.h"

#include "tests/nerf/plane_scene.h"

#include <stdexcept>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace structnerf {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

// Three views of a textured wall that see its only point.
Scene MakeScene() {
  TexturedPlane plane;
  Scene scene;
  for (int v = 0; v < 3; ++v) {
    scene.views.push_back(MakeView(
        std::to_string(v) + ".jpg", MakeCamera(16, 12, 12), {0.2 * v, 0, 0}));
    plane.Photograph(16, 12, &scene.views.back());
  }
  scene.points = {MakePoint(scene, {0, 0, 4}, {0, 1, 2})};
  return scene;
}

const std::vector<std::vector<int>> kAllSources = {{1, 2}, {0, 2}, {0, 1}};

TEST(InspectScene, HealthyScene) {
  const SceneFindings findings = InspectScene(MakeScene(), kAllSources, 0);
  EXPECT_THAT(findings.warnings, IsEmpty());
  EXPECT_EQ(findings.counts.size(), 5u);
  for (const auto& [name, count] : findings.counts) {
    EXPECT_EQ(count, 0) << name;
  }
}

TEST(InspectScene, ManyContradictoryPointsAreWorthAWarning) {
  Scene scene = MakeScene();
  // Those that are left after so many were removed.
  scene.points.resize(90, scene.points[0]);
  EXPECT_THAT(InspectScene(scene, kAllSources, 10).warnings, IsEmpty());
  const SceneFindings findings = InspectScene(scene, kAllSources, 11);
  EXPECT_THAT(findings.warnings, ElementsAre(HasSubstr("11 sparse points")));
  EXPECT_EQ(findings.counts.at("contradictory_point"), 11);
}

TEST(RemoveContradictoryPoints, LeavesPointsWhereTheirViewsSawThem) {
  Scene scene = MakeScene();
  for (View& view : scene.views) {
    view.camera = MakeCamera(1600, 1200, 1200);
  }
  scene.points.clear();
  for (int i = 0; i < 10; ++i) {
    scene.points.push_back(MakePoint(scene, {0.1 * i, 0, 4}, {0, 1, 2}));
  }
  EXPECT_EQ(RemoveContradictoryPoints(&scene), 0);
  EXPECT_EQ(scene.points.size(), 10u);
  // In the mean, 32 pixels are the limit.
  scene.points[0].track[1].xy.x() += 95;
  EXPECT_EQ(RemoveContradictoryPoints(&scene), 0);
  scene.points[0].track[1].xy.x() += 2;
  scene.points[1].xyz = {0, 0, -4};
  scene.points[2].xyz = {1e30, 0, 1e-30};
  EXPECT_EQ(RemoveContradictoryPoints(&scene), 3);
  ASSERT_EQ(scene.points.size(), 7u);
  EXPECT_NEAR(scene.points[0].xyz.x(), 0.3, 1e-12);
}

TEST(RemoveContradictoryPoints, WrongPosesAreNotThePointsFault) {
  Scene scene = MakeScene();
  scene.points.resize(3, scene.points[0]);
  scene.points[0].xyz.y() += 50;
  scene.points[1].xyz.y() += 50;
  EXPECT_EQ(RemoveContradictoryPoints(&scene), 2);
  EXPECT_EQ(scene.points.size(), 3u);
}

TEST(InspectScene, ViewWithoutPoints) {
  Scene scene = MakeScene();
  scene.points[0].track.pop_back();
  const SceneFindings findings = InspectScene(scene, kAllSources, 0);
  EXPECT_THAT(findings.warnings, ElementsAre(HasSubstr("2.jpg")));
  EXPECT_EQ(findings.counts.at("view_without_points"), 1);
}

TEST(InspectScene, ViewWithoutBaseline) {
  const SceneFindings findings = InspectScene(MakeScene(), {{1}, {0}, {}}, 0);
  EXPECT_THAT(findings.warnings, ElementsAre(HasSubstr("2.jpg")));
  EXPECT_EQ(findings.counts.at("view_without_baseline"), 1);
  try {
    InspectScene(MakeScene(), {{}, {}, {}}, 0);
    ADD_FAILURE() << "nothing was thrown";
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(), HasSubstr("all cameras stand in one place"));
  }
}

TEST(InspectScene, ViewFarFromTheOthers) {
  Scene scene = MakeScene();
  scene.views[2] = MakeView("2.jpg", MakeCamera(16, 12, 12), {45, 0, 0});
  TexturedPlane().Photograph(16, 12, &scene.views[2]);
  const SceneFindings findings = InspectScene(scene, kAllSources, 0);
  EXPECT_THAT(findings.warnings,
              ElementsAre(HasSubstr("image 2.jpg stands 11 times as far")));
  EXPECT_EQ(findings.counts.at("view_far_from_others"), 1);
}

TEST(InspectScene, ViewOfSingleColor) {
  Scene scene = MakeScene();
  scene.views[0].image = PlainImage(16, 12, 0);
  scene.views[1].image = PlainImage(16, 12, 200);
  scene.views[1].image.data[7] = 202;
  SceneFindings findings = InspectScene(scene, kAllSources, 0);
  EXPECT_THAT(findings.warnings,
              ElementsAre(HasSubstr("0.jpg"), HasSubstr("1.jpg")));
  EXPECT_EQ(findings.counts.at("view_of_single_color"), 2);
  scene.views[1].image.data[7] = 203;
  findings = InspectScene(scene, kAllSources, 0);
  EXPECT_EQ(findings.counts.at("view_of_single_color"), 1);
  // What is masked does not count, and a view that is all masked shows nothing.
  scene.views[1].mask.assign(16 * 12, 255);
  scene.views[1].mask[7 / 3] = 0;
  scene.views[0].mask.assign(16 * 12, 0);
  findings = InspectScene(scene, kAllSources, 0);
  EXPECT_THAT(findings.warnings, ElementsAre(HasSubstr("1.jpg")));
}

}  // namespace
}  // namespace structnerf
