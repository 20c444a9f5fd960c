// What is found where sources see the wall. Where none does is in
// patch_match_unseen_test.cc.

#include "nerf/stereo/patch_match.h"

#include "nerf/util/random.h"
#include "tests/nerf/stereo/patch_match_scene.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

namespace structnerf {
namespace {

TEST_P(PatchMatchTest, TheTruthMatchesAndStays) {
  const PlaneMaps result = RefineSeed(truth_);
  EXPECT_GT(ShareWithin(result, truth_, kMargin, 0.005), 0.99);
  double sum = 0;
  int num_seen = 0;
  for (const float cost : result.cost) {
    EXPECT_GT(cost, -1e-5f);
    EXPECT_LE(cost, 2.0f);
    if (cost < 2) {
      sum += cost;
      ++num_seen;
    }
  }
  EXPECT_GT(num_seen, static_cast<int>(0.75 * result.cost.size()));
  EXPECT_LT(sum / num_seen, 0.01);
}

TEST_P(PatchMatchTest, DepthAndSlopeAreFound) {
  options_.num_iterations = 4;
  for (const float factor : {0.97f, 1.03f}) {
    for (const bool is_slanted : {true, false}) {
      PlaneMaps seed = Seed(factor);
      if (!is_slanted) {
        std::fill(seed.rho_x.begin(), seed.rho_x.end(), 0.0f);
        std::fill(seed.rho_y.begin(), seed.rho_y.end(), 0.0f);
      }
      EXPECT_LT(ShareWithin(seed, truth_, kMargin, 0.02), 0.01);
      const PlaneMaps result = RefineSeed(seed);
      EXPECT_GT(ShareWithin(result, truth_, kMargin, 0.003), 0.98);
      int num_right_slopes = 0;
      int num_pixels = 0;
      for (int row = kMargin; row < 48 - kMargin; ++row) {
        for (int col = kMargin; col < 67 - kMargin; ++col) {
          const size_t i = static_cast<size_t>(row) * 67 + col;
          // Over a window's radius, within half a percent of the depth.
          const double tolerance =
              0.005 * truth_.rho[i] / options_.window_radius;
          num_right_slopes +=
              std::abs(result.rho_x[i] - truth_.rho_x[i]) < tolerance &&
              std::abs(result.rho_y[i] - truth_.rho_y[i]) < tolerance;
          ++num_pixels;
        }
      }
      EXPECT_GT(num_right_slopes, 0.9 * num_pixels);
    }
  }
}

TEST_P(PatchMatchTest, ExposureDoesNotMatter) {
  options_.num_iterations = 3;
  for (size_t v = 1; v < scene_.views.size(); ++v) {
    for (uint8_t& value : scene_.views[v].image.data) {
      value = static_cast<uint8_t>(0.7 * value + 30);
    }
  }
  EXPECT_GT(ShareWithin(RefineSeed(Seed(1.03f)), truth_, kMargin, 0.004), 0.95);
}

TEST_P(PatchMatchTest, AWrongSourceIsLeftOut) {
  options_.num_iterations = 3;
  options_.num_best_sources = 2;
  RgbImage& wrong = scene_.views[2].image;
  Random random(3);
  for (uint8_t& value : wrong.data) {
    value = static_cast<uint8_t>(random.NextBelow(256));
  }
  EXPECT_GT(ShareWithin(RefineSeed(Seed(1.03f)), truth_, kMargin, 0.004), 0.9);
}

TEST_P(PatchMatchTest, ThreadsDoNotMatter) {
  const PlaneMaps seed = Seed(0.97f);
  const PlaneMaps expected = RefineSeed(seed, 1);
  EXPECT_FALSE(SamePlanes(expected, seed));
  for (const int num_threads : {2, 3}) {
    const PlaneMaps result = RefineSeed(seed, num_threads);
    EXPECT_TRUE(SamePlanes(result, expected));
    EXPECT_EQ(result.cost, expected.cost);
    EXPECT_EQ(result.distinctness, expected.distinctness);
  }
}

TEST_P(PatchMatchTest, ImagesOfAFewPixelsAreHandled) {
  for (const int width : {1, 2, 3}) {
    for (const int height : {1, 2, 3}) {
      View& view = scene_.views[0];
      view.camera = MakeCamera(width, height, 90);
      plane_.Photograph(width, height, &view);
      const PlaneMaps seed = MakePlanes(plane_, view, MakePatchFrame().scale);
      const PlaneMaps result = RefineSeed(seed);
      for (size_t i = 0; i < seed.rho.size(); ++i) {
        EXPECT_NEAR(result.rho[i], seed.rho[i], 0.1 * seed.rho[i]);
      }
    }
  }
}

STRUCTNERF_FOR_EACH_SIMD_TARGET(PatchMatchTest);

// Rounding differs, so a pixel may now and then decide otherwise.
TEST(PatchMatchTargets, Agree) {
  TexturedPlane plane;
  const Scene scene = MakeMatchedScene(&plane);
  PlaneMaps seed = MakePlanes(plane, scene.views[0], MakePatchFrame().scale);
  for (float& rho : seed.rho) {
    rho *= 1.02f;
  }
  const auto run = [&] {
    return RefinePlanes(scene, kAllSources, StereoOptions(), seed);
  };
  const PlaneMaps expected = run();
  for (const int64_t target : hwy::SupportedAndGeneratedTargets()) {
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    const PlaneMaps result = run();
    int num_same = 0;
    for (size_t i = 0; i < result.rho.size(); ++i) {
      EXPECT_NEAR(result.rho[i], expected.rho[i], 0.03 * expected.rho[i]);
      num_same +=
          std::abs(result.rho[i] - expected.rho[i]) < 1e-4 * expected.rho[i] &&
          std::abs(result.cost[i] - expected.cost[i]) < 1e-3;
    }
    EXPECT_GT(num_same, 0.98 * result.rho.size()) << hwy::TargetName(target);
  }
  hwy::SetSupportedTargetsForTest(0);
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
}

TEST(PatchMatchLimits, EndsInTheMiddleOfAViewWhenTold) {
  class AbortLater : public Progress {
   public:
    bool ShouldAbort() override { return ++num_asked_ > 2; }

   private:
    int num_asked_ = 0;
  };
  TexturedPlane plane;
  const Scene scene = MakeMatchedScene(&plane);
  const SceneFrame frame = MakePatchFrame();
  const TrainingViews views(scene, frame);
  const PatchMatch patch_match(
      scene, frame, views, kAllSources, StereoOptions());
  ThreadPool pool(1);
  PlaneMaps maps = MakePlanes(plane, scene.views[0], frame.scale);
  AbortLater progress;
  EXPECT_THROW(patch_match.Refine(0, &pool, &progress, &maps), Aborted);
}

TEST(PatchMatchLimits, MoreSourcesThanThereIsRoomForAreRefused) {
  TexturedPlane plane;
  const Scene scene = MakeMatchedScene(&plane);
  const PlaneMaps seed =
      MakePlanes(plane, scene.views[0], MakePatchFrame().scale);
  const auto sources = [](const size_t count) {
    return PatchSources{std::vector<int>(count, 1), {}, {}, {}};
  };
  EXPECT_THROW(RefinePlanes(scene, sources(33), StereoOptions(), seed),
               std::invalid_argument);
  StereoOptions options;
  options.num_used_sources = 32;
  options.num_best_sources = 32;
  EXPECT_FALSE(
      SamePlanes(RefinePlanes(scene, sources(32), options, seed), seed));
}

}  // namespace
}  // namespace structnerf
