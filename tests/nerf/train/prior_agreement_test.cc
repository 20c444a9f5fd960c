#include "nerf/train/prior_agreement.h"

#include "nerf/train/training_views.h"
#include "tests/nerf/train/objective_scene.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

namespace structnerf {
namespace {

constexpr int kWidth = 24;
constexpr int kHeight = 18;
constexpr int kNumPixels = kWidth * kHeight;
constexpr int kMiddle = 9 * kWidth + 12;

const std::vector<std::vector<int>> kAllSources = {
    {1, 2, 3}, {0, 2, 3}, {0, 1, 3}, {0, 1, 2}};

// Four views of a wall, each with the wall's depth as its prior.
class PriorAgreementTest : public testing::Test {
 protected:
  PriorAgreementTest() {
    for (View& view : test_.scene.views) {
      for (int row = 0; row < kHeight; ++row) {
        for (int col = 0; col < kWidth; ++col) {
          view.prior_depth.push_back(static_cast<float>(
              test_.plane.Depth(view,
                                (col + 0.5) * view.camera.width / kWidth,
                                (row + 0.5) * view.camera.height / kHeight)));
        }
      }
    }
  }

  PriorCounts Estimate() {
    return EstimatePriorDeviations(kAllSources, &test_.scene);
  }

  float RelativeDeviation(const int view_idx, const int pixel) const {
    const View& view = test_.scene.views[view_idx];
    return view.prior_deviation[pixel] / view.prior_depth[pixel];
  }

  ObjectiveScene test_;
};

TEST_F(PriorAgreementTest, PriorsThatAgreeDeviateLeast) {
  const PriorCounts counts = Estimate();
  EXPECT_EQ(counts.num_points_behind, 0u);
  for (int v = 0; v < 4; ++v) {
    ASSERT_EQ(test_.scene.views[v].prior_deviation.size(), kNumPixels);
    EXPECT_NEAR(RelativeDeviation(v, kMiddle), 0.05, 1e-6);
  }
}

// One view is wrong by 30 %; the others still have two that agree, but the mean
// is over up to four.
TEST_F(PriorAgreementTest, DisagreementShows) {
  for (float& depth : test_.scene.views[0].prior_depth) {
    depth *= 1.3f;
  }
  Estimate();
  EXPECT_NEAR(RelativeDeviation(0, kMiddle), 0.3 / 1.3, 0.03);
  EXPECT_NEAR(RelativeDeviation(1, kMiddle), 0.1, 0.02);
}

TEST_F(PriorAgreementTest, WhatNobodyConfirmsDeviatesMost) {
  for (int v = 1; v < 4; ++v) {
    test_.scene.views[v].prior_depth.clear();
  }
  test_.scene.views[0].prior_depth[0] = 0;
  const PriorCounts counts = Estimate();
  EXPECT_EQ(counts.num_unconfirmed, kNumPixels - 1u);
  EXPECT_NEAR(RelativeDeviation(0, kMiddle), 0.5, 1e-6);
  EXPECT_EQ(test_.scene.views[0].prior_deviation[0], 0);
  EXPECT_TRUE(test_.scene.views[1].prior_deviation.empty());
}

TEST_F(PriorAgreementTest, KnownDeviationsStay) {
  test_.scene.views[2].prior_deviation.assign(kNumPixels, 0.123f);
  Estimate();
  EXPECT_EQ(test_.scene.views[2].prior_deviation[kMiddle], 0.123f);
}

// A camera that has walked through the wall looks away from it.
TEST_F(PriorAgreementTest, PointsBehindCamerasAreLeftOut) {
  test_.scene.views[1].cam_from_world_translation.z() -= 100;
  const PriorCounts counts = Estimate();
  EXPECT_GE(counts.num_points_behind, 3u * kNumPixels);
  EXPECT_NEAR(RelativeDeviation(0, kMiddle), 0.05, 1e-6);
  EXPECT_NEAR(RelativeDeviation(1, kMiddle), 0.5, 1e-6);
}

TEST_F(PriorAgreementTest, BoundsSurroundThePrior) {
  Estimate();
  test_.scene.views[0].prior_depth[5] = 0;
  BoundRaysByPriors(test_.frame, &test_.scene);
  const View& view = test_.scene.views[0];
  const float depth = view.prior_depth[kMiddle];
  EXPECT_NEAR(view.near_depth[kMiddle], 0.95f * depth, 1e-4f * depth);
  EXPECT_NEAR(view.far_depth[kMiddle], 1.05f * depth, 1e-4f * depth);
  EXPECT_EQ(view.near_depth[5], 0);
  EXPECT_EQ(view.far_depth[5], 0);

  // Rays follow them, in training and for any size of the camera.
  for (const int factor : {1, 2}) {
    const ViewGeometry geometry(
        view,
        view.camera.Resized(factor * kWidth, factor * kHeight),
        test_.frame);
    RayTile rays;
    geometry.SetRay(factor * 12.5, factor * 9.5, 0, &rays);
    geometry.SetRay(factor * 5.5, factor * 0.5, 1, &rays);
    const double scale = test_.frame.scale;
    EXPECT_NEAR(rays.near[0], scale * view.near_depth[kMiddle], 1e-6);
    EXPECT_NEAR(rays.far[0], scale * view.far_depth[kMiddle], 1e-6);
    EXPECT_NEAR(rays.near[1], test_.frame.near, 1e-6);
  }
}

TEST_F(PriorAgreementTest, RangesAreAtMost15Percent) {
  for (View& view : test_.scene.views) {
    view.prior_deviation = view.prior_depth;
  }
  BoundRaysByPriors(test_.frame, &test_.scene);
  const View& view = test_.scene.views[0];
  EXPECT_NEAR(view.near_depth[kMiddle] / view.prior_depth[kMiddle], 0.85, 1e-3);
}

// Behind the scene box, or before its first sample.
TEST_F(PriorAgreementTest, InvertedRangesAreCountedAndLeftOpen) {
  Estimate();
  // The corners of the wall are outside of the box, too.
  const size_t num_corners =
      BoundRaysByPriors(test_.frame, &test_.scene).num_inverted_ranges;
  View& view = test_.scene.views[0];
  view.prior_depth[kMiddle] = 1000;
  view.prior_deviation[kMiddle] = 50;
  view.prior_depth[kMiddle + 1] =
      static_cast<float>(0.1 * test_.frame.near / test_.frame.scale);
  view.near_depth.clear();
  view.far_depth.clear();
  const PriorCounts counts = BoundRaysByPriors(test_.frame, &test_.scene);
  EXPECT_EQ(counts.num_inverted_ranges, num_corners + 2);
  EXPECT_EQ(view.near_depth[kMiddle], 0);
  EXPECT_EQ(view.far_depth[kMiddle + 1], 0);
  EXPECT_GT(view.near_depth[kMiddle + 2], 0);
}

}  // namespace
}  // namespace structnerf
