// PlaneMaps::distinctness.

#include "nerf/stereo/patch_match.h"
#include "tests/nerf/stereo/patch_match_scene.h"

#include <limits>
#include <vector>

namespace structnerf {
namespace {

// Mean over the pixels at least `kMargin` away from the border.
double MeanDistinctness(const PlaneMaps& maps) {
  double sum = 0;
  int count = 0;
  for (int row = kMargin; row < maps.height - kMargin; ++row) {
    for (int col = kMargin; col < maps.width - kMargin; ++col) {
      sum += maps.distinctness[static_cast<size_t>(row) * maps.width + col];
      ++count;
    }
  }
  return sum / count;
}

TEST_P(PatchMatchTest, TextureIsDistinctAtItsDepth) {
  const PlaneMaps result = RefineSeed(truth_);
  // The baseline is short.
  EXPECT_GT(MeanDistinctness(result), 0.03);
  for (const float distinctness : result.distinctness) {
    EXPECT_LE(distinctness, 2.0f);
  }
  // Where it would match better a little farther away, it is not.
  options_.num_iterations = 0;
  EXPECT_LT(MeanDistinctness(RefineSeed(Seed(1.03f))), 0);
}

TEST_P(PatchMatchTest, BlankSurfacesAreNotDistinct) {
  for (View& view : scene_.views) {
    view.image = PlainImage(view.image.width, view.image.height, 90);
  }
  for (const float distinctness : RefineSeed(Seed(1.03f)).distinctness) {
    EXPECT_NEAR(distinctness, 0.0f, 1e-3f);
  }
}

TEST_P(PatchMatchTest, WhatNoSourceSeesIsNotDistinct) {
  // Sees the left of the wall only: some pixels would be seen a little farther
  // away.
  View& source = scene_.views[1];
  source = MakeView("far left", source.camera, Eigen::Vector3d(-2.0, 0, 0));
  plane_.Photograph(67, 48, &source);
  PlaneMaps seed = Seed(1.03f);
  seed.rho[24 * 67 + 5] = 0;
  seed.rho[24 * 67 + 8] = std::numeric_limits<float>::quiet_NaN();
  const PlaneMaps result =
      RefinePlanes(scene_, {{1}, {}, {}, {}}, options_, seed);
  int num_unseen = 0;
  for (size_t i = 0; i < result.cost.size(); ++i) {
    if (result.cost[i] == 2.0f) {
      EXPECT_EQ(result.distinctness[i], 0.0f) << i;
      ++num_unseen;
    }
  }
  EXPECT_GT(num_unseen, 100);
  const PlaneMaps alone =
      RefinePlanes(scene_, {{}, {}, {}, {}}, options_, seed);
  EXPECT_EQ(alone.distinctness, std::vector<float>(67 * 48, 0.0f));
}

STRUCTNERF_FOR_EACH_SIMD_TARGET(PatchMatchTest);

}  // namespace
}  // namespace structnerf
