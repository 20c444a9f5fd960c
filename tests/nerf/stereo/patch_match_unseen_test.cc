// Pixels that nothing can be said about keep what they had.

#include "nerf/stereo/patch_match.h"
#include "tests/nerf/stereo/patch_match_scene.h"

#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

namespace structnerf {
namespace {

TEST_P(PatchMatchTest, BlankImagesKeepTheSeed) {
  for (View& view : scene_.views) {
    view.image = PlainImage(view.image.width, view.image.height, 200);
  }
  const PlaneMaps seed = Seed(1.03f);
  const PlaneMaps result = RefineSeed(seed);
  EXPECT_TRUE(SamePlanes(result, seed));
  for (const float cost : result.cost) {
    EXPECT_TRUE(std::abs(cost - 1) < 1e-6f || cost == 2.0f) << cost;
  }
  EXPECT_NEAR(result.cost[24 * 67 + 33], 1.0f, 1e-6f);
}

TEST_P(PatchMatchTest, MaskedPixelsKeepTheSeed) {
  options_.num_iterations = 4;
  View& view = scene_.views[0];
  view.mask.assign(67 * 48, 255);
  const auto is_masked = [](const int col, const int row) {
    return col >= 30 && col < 40 && row >= 20 && row < 30;
  };
  for (int row = 0; row < 48; ++row) {
    for (int col = 0; col < 67; ++col) {
      if (is_masked(col, row)) {
        view.mask[row * 67 + col] = 0;
        // What lies under the mask must not show.
        view.image.data[3 * (row * 67 + col)] = row % 2 * 255;
      }
    }
  }
  const PlaneMaps seed = Seed(1.03f);
  const PlaneMaps result = RefineSeed(seed);
  int num_good = 0;
  int num_unmasked = 0;
  for (int row = 12; row < 38; ++row) {
    for (int col = 22; col < 48; ++col) {
      const size_t i = static_cast<size_t>(row) * 67 + col;
      if (is_masked(col, row)) {
        EXPECT_TRUE(SamePlane(result, seed, i));
        EXPECT_GE(result.cost[i], 0.99f);
      } else {
        ++num_unmasked;
        num_good += std::abs(result.rho[i] / truth_.rho[i] - 1) < 0.005;
      }
    }
  }
  EXPECT_GT(num_good, 0.95 * num_unmasked);
}

TEST_P(PatchMatchTest, MaskedSourcesAreNotCompared) {
  const PlaneMaps seed = Seed(1.03f);
  for (const size_t v : {1, 2}) {
    scene_.views[v].mask.assign(67 * 48, 0);
  }
  options_.num_iterations = 1;
  const PlaneMaps expected =
      RefinePlanes(scene_, {{3}, {}, {}, {}}, options_, seed);
  EXPECT_TRUE(SamePlanes(RefineSeed(seed), expected));
  scene_.views[3].mask.assign(70 * 50, 0);
  const PlaneMaps result = RefineSeed(seed);
  EXPECT_TRUE(SamePlanes(result, seed));
  EXPECT_EQ(result.cost, std::vector<float>(67 * 48, 2.0f));
}

TEST_P(PatchMatchTest, OutsideOfTheSourceNothingChanges) {
  // Sees the left of the wall only.
  View& source = scene_.views[1];
  source = MakeView("far left", source.camera, Eigen::Vector3d(-2.0, 0, 0));
  plane_.Photograph(67, 48, &source);
  const PlaneMaps seed = Seed(1.03f);
  const PlaneMaps result =
      RefinePlanes(scene_, {{1}, {}, {}, {}}, options_, seed);
  int num_seen = 0;
  for (int row = 0; row < 48; ++row) {
    for (int col = 0; col < 67; ++col) {
      const size_t i = static_cast<size_t>(row) * 67 + col;
      num_seen += result.cost[i] < 2;
      // Where even a depth that is off by a tenth is not in the picture.
      const double depth = plane_.Depth(scene_.views[0], col + 0.5, row + 0.5);
      const double x = col + 0.5 + 90 * 2.0 / (depth * 1.1);
      if (x > 67 + 1) {
        EXPECT_TRUE(SamePlane(result, seed, i)) << col << " " << row;
        EXPECT_EQ(result.cost[i], 2.0f) << col << " " << row;
      }
    }
  }
  EXPECT_GT(num_seen, 0);
}

TEST_P(PatchMatchTest, SourcesBehindTheWallSeeNothing) {
  View& source = scene_.views[1];
  const RgbImage image = source.image;
  source = MakeView("behind", source.camera, Eigen::Vector3d(0, 0, 20));
  source.image = image;
  const PlaneMaps seed = Seed(1.03f);
  const PlaneMaps result =
      RefinePlanes(scene_, {{1}, {}, {}, {}}, options_, seed);
  EXPECT_TRUE(SamePlanes(result, seed));
  EXPECT_EQ(result.cost, std::vector<float>(67 * 48, 2.0f));
}

TEST_P(PatchMatchTest, WithoutSourcesNothingChanges) {
  const PlaneMaps seed = Seed(1.03f);
  for (const PatchSources& sources :
       {PatchSources{{}, {}, {}, {}}, PatchSources{{}, {0, 2}, {0}, {0}}}) {
    const PlaneMaps result = RefinePlanes(scene_, sources, options_, seed);
    EXPECT_TRUE(SamePlanes(result, seed));
    EXPECT_EQ(result.cost, std::vector<float>(67 * 48, 2.0f));
  }
}

TEST_P(PatchMatchTest, PixelsWithoutSeedStayAndDoNotSpread) {
  options_.num_iterations = 4;
  PlaneMaps seed = Seed(1.03f);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float inf = std::numeric_limits<float>::infinity();
  const std::vector<float> kNoSeeds = {0.0f, -0.3f, nan, inf, -inf};
  const size_t first = 24 * 67 + 20;
  for (size_t k = 0; k < kNoSeeds.size(); ++k) {
    seed.rho[first + 4 * k] = kNoSeeds[k];
    // A plane may lack its slope only.
    seed.rho_x[first + 4 * k + 67] = nan;
  }
  const PlaneMaps result = RefineSeed(seed);
  for (size_t k = 0; k < kNoSeeds.size(); ++k) {
    EXPECT_TRUE(std::memcmp(&result.rho[first + 4 * k],
                            &kNoSeeds[k],
                            sizeof(float)) == 0);
    EXPECT_EQ(result.cost[first + 4 * k], 2.0f);
    EXPECT_EQ(result.rho[first + 4 * k + 67], seed.rho[first + 4 * k + 67]);
    EXPECT_EQ(result.cost[first + 4 * k + 67], 2.0f);
  }
  EXPECT_GT(ShareWithin(result, truth_, kMargin, 0.003), 0.98);
}

STRUCTNERF_FOR_EACH_SIMD_TARGET(PatchMatchTest);

}  // namespace
}  // namespace structnerf
