#include "nerf/train/depth_prior.h"

#include "tests/nerf/plane_scene.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

namespace structnerf {
namespace {

// Two views with cameras of 40 x 30 and images of half that size.
Scene MakeTwoViews() {
  Scene scene;
  scene.views = {MakeView("a", MakeCamera(40, 30, 30), {0, 0, 0}),
                 MakeView("b", MakeCamera(40, 30, 30), {0.5, 0, 0.25})};
  for (View& view : scene.views) {
    view.image = PlainImage(20, 15, 0);
  }
  return scene;
}

void AddPoint(Scene* scene, const double error) {
  scene->points.push_back(MakePoint(*scene, {0.1, 0.2, 4}, {0, 1}, error));
}

TEST(CollectDepthSamples, PlaceAndDepth) {
  Scene scene = MakeTwoViews();
  AddPoint(&scene, 1);
  const auto samples = CollectDepthSamples(scene);
  ASSERT_EQ(samples.size(), 2u);
  for (int v = 0; v < 2; ++v) {
    ASSERT_EQ(samples[v].size(), 1u);
    const Eigen::Vector3d projection =
        Project(scene.views[v], scene.points[0].xyz);
    EXPECT_EQ(samples[v][0].view_idx, v);
    EXPECT_DOUBLE_EQ(samples[v][0].x, 0.5 * projection.x());
    EXPECT_DOUBLE_EQ(samples[v][0].y, 0.5 * projection.y());
    EXPECT_DOUBLE_EQ(samples[v][0].depth, projection.z());
  }
}

TEST(CollectDepthSamples, WeightFallsWithTheError) {
  Scene scene = MakeTwoViews();
  // The mean is 1; the unknown one counts neither for it nor against itself.
  for (const double error : {0.5, 1.0, 1.5, -1.0, 0.0, 2.0}) {
    AddPoint(&scene, error);
  }
  const auto samples = CollectDepthSamples(scene);
  const double expected[] = {0.25, 1, 2.25, 0, 0, 4};
  const double error_ratios[] = {0.5, 1, 1.5, 1, 0, 2};
  ASSERT_EQ(samples[0].size(), 6u);
  for (int i = 0; i < 6; ++i) {
    EXPECT_NEAR(samples[0][i].weight, std::exp(-expected[i]), 1e-6) << i;
    EXPECT_EQ(samples[1][i].weight, samples[0][i].weight);
    EXPECT_NEAR(samples[0][i].error_ratio, error_ratios[i], 1e-6);
  }
}

// The ratio of errors counts, not their unit.
TEST(CollectDepthSamples, WeightDoesNotDependOnTheScaleOfErrors) {
  for (const double scale : {1e-6, 1.0, 1e6}) {
    Scene scene = MakeTwoViews();
    AddPoint(&scene, 0.5 * scale);
    AddPoint(&scene, 1.5 * scale);
    const auto samples = CollectDepthSamples(scene);
    EXPECT_NEAR(samples[0][0].weight, std::exp(-0.25), 1e-6);
    EXPECT_NEAR(samples[0][1].weight, std::exp(-2.25), 1e-6);
  }
}

TEST(CollectDepthSamples, ErrorsThatAreUnknownOrAllZeroTrustEveryPoint) {
  for (const double error : {-1.0, 0.0}) {
    Scene scene = MakeTwoViews();
    AddPoint(&scene, error);
    AddPoint(&scene, error);
    for (const auto& view_samples : CollectDepthSamples(scene)) {
      ASSERT_EQ(view_samples.size(), 2u);
      for (const DepthSample& sample : view_samples) {
        EXPECT_EQ(sample.weight, 1.0f);
      }
    }
  }
}

TEST(CollectDepthSamples, OnlyVisiblePlacesInFrontOfTheCamera) {
  Scene scene = MakeTwoViews();
  const auto add = [&](const double x, const double y, const double depth) {
    SparsePoint point;
    point.xyz = {0, 0, depth};
    point.track = {{0, {x, y}}};
    scene.points.push_back(point);
  };
  add(20, 15, 4);        // counts
  add(0, 0, 4);          // counts, the very corner
  add(39.99, 29.99, 4);  // counts
  add(40, 15, 4);
  add(20, 30, 4);
  add(-0.01, 15, 4);
  add(20, -0.01, 4);
  add(20, 15, 0);
  add(20, 15, -4);
  EXPECT_EQ(CollectDepthSamples(scene)[0].size(), 3u);
  // Masks are as large as the image: (20, 15) lies in its pixel (10, 7).
  scene.views[0].mask.assign(300, 255);
  scene.views[0].mask[7 * 20 + 10] = 0;
  EXPECT_EQ(CollectDepthSamples(scene)[0].size(), 2u);
  scene.views[0].mask[14 * 20 + 19] = 0;
  EXPECT_EQ(CollectDepthSamples(scene)[0].size(), 1u);
}

std::vector<DepthSample> MakeSamples(
    const std::vector<Eigen::Vector3d>& places_and_depths) {
  std::vector<DepthSample> samples;
  for (const Eigen::Vector3d& place : places_and_depths) {
    DepthSample sample;
    sample.x = place.x();
    sample.y = place.y();
    sample.depth = place.z();
    samples.push_back(sample);
  }
  return samples;
}

TEST(InterpolateDepth, ByHand) {
  EXPECT_EQ(InterpolateDepth({}, 3, 4), 0);
  EXPECT_NEAR(InterpolateDepth(MakeSamples({{0, 0, 2.5}}), 30, 4), 2.5, 1e-12);
  // Half way between inverse depths 1 and 0.25.
  const auto two = MakeSamples({{0, 0, 1}, {10, 0, 4}});
  EXPECT_NEAR(InterpolateDepth(two, 5, 0), 1 / 0.625, 1e-12);
  // Weights 1 / (0 + 1) and 1 / (100 + 1) at the first.
  EXPECT_NEAR(
      InterpolateDepth(two, 0, 0), (1 + 1 / 101.0) / (1 + 0.25 / 101.0), 1e-12);
}

TEST(InterpolateDepth, EightNearestCount) {
  std::vector<Eigen::Vector3d> places;
  for (int i = 0; i < 8; ++i) {
    places.emplace_back(i % 3, i / 3, 2.0);
  }
  const double expected = InterpolateDepth(MakeSamples(places), 1, 1);
  EXPECT_NEAR(expected, 2, 1e-12);
  // Others, before and after them, do not, as near as they may be.
  places.insert(places.begin(), {4, 4, 100.0});
  places.emplace_back(-2, -2, 0.01);
  EXPECT_NEAR(InterpolateDepth(MakeSamples(places), 1, 1), expected, 1e-12);
}

TEST(InterpolateDepth, AnyScale) {
  for (const double scale : {1e-6, 1e6}) {
    const auto samples =
        MakeSamples({{0, 0, scale}, {10, 0, 2 * scale}, {0, 10, 3 * scale}});
    const double depth = InterpolateDepth(samples, 3, 3);
    EXPECT_GT(depth, scale);
    EXPECT_LT(depth, 3 * scale);
  }
}

}  // namespace
}  // namespace structnerf
