#include "nerf/extract/depth_averaging.h"

#include "tests/nerf/aborting_progress.h"
#include "tests/nerf/plane_scene.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace structnerf {
namespace {

using testing::ElementsAre;

constexpr int kWidth = 40;
constexpr int kHeight = 30;

// Three cameras in front of a slanted wall. View 0 has its depth times
// `factors[0]`, and so on.
class AverageDepthTest : public testing::Test {
 protected:
  AverageDepthTest() {
    plane_.normal = {0.3, -0.4, -1};
    for (int v = 0; v < 3; ++v) {
      // Different cameras, so that intrinsics cannot be mixed up.
      scene_.views.push_back(MakeView("view",
                                      {kWidth + v,
                                       kHeight,
                                       50.0 + v,
                                       52.0 + v,
                                       0.5 * kWidth,
                                       0.5 * kHeight},
                                      {0.2 * v, 0.05 * v, -0.1 * v}));
    }
    MakeMaps({1, 1, 1});
  }

  void MakeMaps(const std::vector<double>& factors) {
    confirmed_.clear();
    for (int v = 0; v < 3; ++v) {
      confirmed_.push_back(plane_.DepthMap(scene_.views[v], factors[v]));
    }
    depth_ = confirmed_[0].depth;
  }

  DepthAgreement Average(const std::vector<int>& view_idxs = {1, 2}) {
    ThreadPool pool(2);
    Progress progress;
    return AverageDepth(
        scene_, confirmed_, 0, view_idxs, options_, &pool, &progress, &depth_);
  }

  // What the depth of the middle pixel is of the true one.
  double Factor() const {
    const size_t i = Middle();
    return depth_[i] / plane_.Depth(scene_.views[0], kWidth / 2, kHeight / 2);
  }

  static size_t Middle() { return kHeight / 2 * kWidth + kWidth / 2; }

  TexturedPlane plane_;
  Scene scene_;
  std::vector<DenseMaps> confirmed_;  // of all views
  std::vector<float> depth_;          // of view 0
  ExtractionOptions options_;
};

TEST_F(AverageDepthTest, TheTruthStays) {
  const std::vector<float> depth = depth_;
  Average();
  for (size_t i = 0; i < depth.size(); ++i) {
    EXPECT_NEAR(depth_[i], depth[i], 1e-5 * depth[i]);
  }
}

TEST_F(AverageDepthTest, TakesTheMean) {
  MakeMaps({0.99, 1.02, 1.03});
  Average();
  // The others' depth is along their rays, nearly the same way as this one's.
  EXPECT_NEAR(Factor(), (0.99 + 1.02 + 1.03) / 3, 1e-3);
}

TEST_F(AverageDepthTest, WhatIsNotConfirmedCountsForNothing) {
  MakeMaps({0.98, 1.01, 1.02});
  confirmed_[0].depth[Middle()] = 0;
  Average();
  EXPECT_NEAR(Factor(), (1.01 + 1.02) / 2, 1e-3);
  EXPECT_NEAR(depth_[Middle() + 1] /
                  plane_.Depth(scene_.views[0], kWidth / 2 + 1, kHeight / 2),
              (0.98 + 1.01 + 1.02) / 3,
              1e-3);
}

TEST_F(AverageDepthTest, WhatNoOtherViewSeesStays) {
  MakeMaps({0.98, 1.01, 1.02});
  confirmed_[0].depth.assign(depth_.size(), 0);
  Average({});
  EXPECT_NEAR(Factor(), 0.98, 1e-6);
  // The same where they have no depth.
  for (const int v : {1, 2}) {
    confirmed_[v].depth.assign(confirmed_[v].depth.size(), 0);
  }
  Average();
  EXPECT_NEAR(Factor(), 0.98, 1e-6);
}

TEST_F(AverageDepthTest, OtherSurfacesDoNotCount) {
  MakeMaps({1, 1.01, 1.2});
  options_.averaging_max_depth_error = 0.05;
  Average();
  EXPECT_NEAR(Factor(), (1 + 1.01) / 2, 1e-3);
  options_.averaging_max_depth_error = 0.5;
  MakeMaps({1, 1.01, 1.2});
  Average();
  EXPECT_NEAR(Factor(), (1 + 1.01 + 1.2) / 3, 1e-2);
}

// Where four pixels are interpolated, all must be of the surface.
TEST_F(AverageDepthTest, SurfacesAreNotMixedAtTheirEdges) {
  MakeMaps({0.98, 1.01, 1.01});
  const Eigen::Vector3d there = Project(
      scene_.views[1],
      Unproject(scene_.views[0], kWidth / 2, kHeight / 2, depth_[Middle()]));
  const int corner = static_cast<int>(there.y() + 1) * confirmed_[1].width +
                     static_cast<int>(there.x());
  for (const float factor : {0.0f, 0.9f, 1.1f}) {
    MakeMaps({0.98, 1.01, 1.01});
    confirmed_[1].depth[corner] *= factor;
    Average({1});
    EXPECT_NEAR(Factor(), 0.98, 1e-6);
  }
}

TEST_F(AverageDepthTest, PixelsWithoutDepthStayWithout) {
  depth_[Middle()] = 0;
  confirmed_[0].depth[Middle()] = 0;
  Average();
  EXPECT_EQ(depth_[Middle()], 0);
}

TEST_F(AverageDepthTest, TellsHowWellDepthsAgree) {
  MakeMaps({0.98, 1.01, 1.03});
  const DepthAgreement agreement = Average();
  EXPECT_EQ(agreement.num_depths[Middle()], 3);
  // Relative to 0.98: deviations from the mean of -0.0267, 0.0033, 0.0233.
  EXPECT_NEAR(agreement.spread[Middle()], 0.0210, 5e-4);
  EXPECT_EQ(agreement.is_confirmed[Middle()], 1);
  for (size_t i = 0; i < depth_.size(); ++i) {
    EXPECT_EQ(agreement.is_confirmed[i],
              agreement.num_depths[i] >= options_.min_num_consistent);
    if (agreement.num_depths[i] < 2) {
      EXPECT_EQ(agreement.spread[i], 0);
    }
  }
}

TEST_F(AverageDepthTest, ThePixelItselfCountsOnlyIfItIsConfirmed) {
  confirmed_[0].depth[Middle()] = 0;
  EXPECT_EQ(Average().num_depths[Middle()], 2);
  EXPECT_EQ(Average().is_confirmed[Middle()], 1);
  options_.min_num_consistent = 3;
  EXPECT_EQ(Average().is_confirmed[Middle()], 0);
}

TEST_F(AverageDepthTest, TheGraphHasTheOtherViewsOfConfirmedPixels) {
  options_.min_num_consistent = 3;
  const DepthAgreement agreement = Average({2, 1});
  int num_confirmed = 0;
  for (auto record = agreement.graph.begin(); record != agreement.graph.end();
       record += 3 + record[2]) {
    EXPECT_EQ(agreement.is_confirmed[record[1] * kWidth + record[0]], 1);
    EXPECT_THAT(std::vector<int>(record + 3, record + 3 + record[2]),
                ElementsAre(1, 2));
    ++num_confirmed;
  }
  EXPECT_EQ(
      num_confirmed,
      std::count(
          agreement.is_confirmed.begin(), agreement.is_confirmed.end(), 1));
  EXPECT_GT(num_confirmed, 0);
}

TEST_F(AverageDepthTest, Aborts) {
  ThreadPool pool(1);
  AbortingProgress progress;
  EXPECT_THROW(
      AverageDepth(
          scene_, confirmed_, 0, {1, 2}, options_, &pool, &progress, &depth_),
      Aborted);
}

}  // namespace
}  // namespace structnerf
