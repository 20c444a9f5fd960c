#include "nerf/stereo/patch_match.h"

#include "nerf/util/random.h"
#include "tests/nerf/plane_scene.h"
#include "tests/nerf/simd_targets.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <stdexcept>
#include <vector>

namespace structnerf {
namespace {

using Sources = std::vector<std::vector<int>>;

// Field coordinates of a scene that is not where the world's origin is, so that
// a forgotten conversion shows.
SceneFrame MakeFrame() {
  SceneFrame frame;
  frame.origin = Eigen::Vector3d(-3, -2, -1);
  frame.scale = 0.125;
  return frame;
}

// Four views of a slanted wall; the last one's image is half its camera's size.
Scene MakeSlantedScene(TexturedPlane* plane) {
  plane->normal = Eigen::Vector3d(0.4, -0.25, -1);
  plane->wavelength = 0.35;
  Scene scene;
  const PinholeCamera camera = MakeCamera(67, 48, 90);
  scene.views = {MakeView("middle", camera, Eigen::Vector3d(0, 0, 0)),
                 MakeView("right",
                          camera,
                          Eigen::Vector3d(0.7, 0.1, 0.1),
                          Eigen::Vector3d(-0.17, 0, 1)),
                 MakeView("left",
                          camera,
                          Eigen::Vector3d(-0.6, -0.2, 0),
                          Eigen::Vector3d(0.15, 0.03, 1)),
                 MakeView("above",
                          MakeCamera(140, 100, 190),
                          Eigen::Vector3d(0.1, -0.7, -0.1),
                          Eigen::Vector3d(0, 0.16, 1))};
  for (size_t v = 0; v < 3; ++v) {
    plane->Photograph(67, 48, &scene.views[v]);
  }
  plane->Photograph(70, 50, &scene.views[3]);
  return scene;
}

// The plane as the first view sees it, in field units per pixel of its image.
PlaneMaps MakePlanes(const TexturedPlane& plane,
                     const View& view,
                     const double scale) {
  PlaneMaps maps;
  maps.width = view.image.width;
  maps.height = view.image.height;
  const auto rho = [&](const double x, const double y) {
    const double ratio_x = static_cast<double>(view.camera.width) / maps.width;
    const double ratio_y =
        static_cast<double>(view.camera.height) / maps.height;
    return 1 / (scale * plane.Depth(view, x * ratio_x, y * ratio_y));
  };
  for (int row = 0; row < maps.height; ++row) {
    for (int col = 0; col < maps.width; ++col) {
      const double x = col + 0.5;
      const double y = row + 0.5;
      maps.rho.push_back(static_cast<float>(rho(x, y)));
      maps.rho_x.push_back(static_cast<float>(rho(x + 1, y) - rho(x, y)));
      maps.rho_y.push_back(static_cast<float>(rho(x, y + 1) - rho(x, y)));
    }
  }
  return maps;
}

PlaneMaps Refine(const Scene& scene,
                 const Sources& sources,
                 const StereoOptions& options,
                 const PlaneMaps& seed,
                 const int num_threads = 1) {
  const SceneFrame frame = MakeFrame();
  const TrainingViews views(scene, frame);
  const PatchMatch patch_match(scene, frame, views, sources, options);
  ThreadPool pool(num_threads);
  PlaneMaps maps = seed;
  Progress progress;
  patch_match.Refine(0, &pool, &progress, &maps);
  return maps;
}

bool SamePlanes(const PlaneMaps& a, const PlaneMaps& b) {
  const auto same = [](const std::vector<float>& x,
                       const std::vector<float>& y) {
    return x.size() == y.size() &&
           std::memcmp(x.data(), y.data(), x.size() * sizeof(float)) == 0;
  };
  return same(a.rho, b.rho) && same(a.rho_x, b.rho_x) && same(a.rho_y, b.rho_y);
}

bool SamePlane(const PlaneMaps& a, const PlaneMaps& b, const size_t i) {
  return a.rho[i] == b.rho[i] && a.rho_x[i] == b.rho_x[i] &&
         a.rho_y[i] == b.rho_y[i];
}

// Share of the pixels at least `margin` away from the border whose depth is
// within a relative `tolerance` of the true one.
double ShareWithin(const PlaneMaps& maps,
                   const PlaneMaps& truth,
                   const int margin,
                   const double tolerance) {
  int num_good = 0;
  int num_all = 0;
  for (int row = margin; row < maps.height - margin; ++row) {
    for (int col = margin; col < maps.width - margin; ++col) {
      const size_t i = static_cast<size_t>(row) * maps.width + col;
      num_good += std::abs(maps.rho[i] / truth.rho[i] - 1) < tolerance;
      ++num_all;
    }
  }
  return static_cast<double>(num_good) / num_all;
}

const Sources kAllSources = {{1, 2, 3}, {0}, {0}, {0}};

class PatchMatchTest : public SimdTargetTest {
 protected:
  PatchMatchTest()
      : scene_(MakeSlantedScene(&plane_)),
        truth_(MakePlanes(plane_, scene_.views[0], MakeFrame().scale)) {}

  // The true planes, their depth off by a factor.
  PlaneMaps Seed(const float factor) const {
    PlaneMaps seed = truth_;
    for (size_t i = 0; i < seed.rho.size(); ++i) {
      seed.rho[i] *= factor;
      seed.rho_x[i] *= factor;
      seed.rho_y[i] *= factor;
    }
    return seed;
  }

  PlaneMaps RefineSeed(const PlaneMaps& seed, const int num_threads = 1) const {
    return Refine(scene_, kAllSources, options_, seed, num_threads);
  }

  TexturedPlane plane_;
  Scene scene_;
  PlaneMaps truth_;
  StereoOptions options_;
};

// Pixels whose window no photograph cuts off.
constexpr int kMargin = 6;

TEST_P(PatchMatchTest, TheTruthMatchesAndStays) {
  const PlaneMaps result = RefineSeed(truth_);
  EXPECT_GT(ShareWithin(result, truth_, kMargin, 0.002), 0.99);
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

TEST_P(PatchMatchTest, WithoutPriorDepthAndSlopeAreFound) {
  options_.prior_weight = 0;
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

// The default weight holds back, but at least half of the error goes.
TEST_P(PatchMatchTest, WithPriorDepthIsFoundHalfway) {
  for (const float factor : {0.97f, 1.03f}) {
    const PlaneMaps result = RefineSeed(Seed(factor));
    EXPECT_GT(ShareWithin(result, truth_, kMargin, 0.015), 0.75);
    options_.prior_weight = 10;
    EXPECT_GT(ShareWithin(RefineSeed(Seed(factor)), Seed(factor), 0, 0.005),
              0.99);
    options_.prior_weight = StereoOptions().prior_weight;
  }
}

TEST_P(PatchMatchTest, ExposureDoesNotMatter) {
  options_.prior_weight = 0;
  options_.num_iterations = 3;
  for (size_t v = 1; v < scene_.views.size(); ++v) {
    for (uint8_t& value : scene_.views[v].image.data) {
      value = static_cast<uint8_t>(0.7 * value + 30);
    }
  }
  EXPECT_GT(ShareWithin(RefineSeed(Seed(1.03f)), truth_, kMargin, 0.004), 0.95);
}

TEST_P(PatchMatchTest, AWrongSourceIsLeftOut) {
  options_.prior_weight = 0;
  options_.num_iterations = 3;
  options_.num_best_sources = 2;
  RgbImage& wrong = scene_.views[2].image;
  Random random(3);
  for (uint8_t& value : wrong.data) {
    value = static_cast<uint8_t>(random.NextBelow(256));
  }
  EXPECT_GT(ShareWithin(RefineSeed(Seed(1.03f)), truth_, kMargin, 0.004), 0.9);
}

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
  options_.prior_weight = 0;
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
  const PlaneMaps expected = Refine(scene_, {{3}, {}, {}, {}}, options_, seed);
  EXPECT_TRUE(SamePlanes(RefineSeed(seed), expected));
  scene_.views[3].mask.assign(70 * 50, 0);
  const PlaneMaps result = RefineSeed(seed);
  EXPECT_TRUE(SamePlanes(result, seed));
  EXPECT_EQ(result.cost, std::vector<float>(67 * 48, 2.0f));
}

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
  const PlaneMaps result = Refine(scene_, {{1}, {}, {}, {}}, options_, seed);
  int num_unseen = 0;
  for (size_t i = 0; i < result.cost.size(); ++i) {
    if (result.cost[i] == 2.0f) {
      EXPECT_EQ(result.distinctness[i], 0.0f) << i;
      ++num_unseen;
    }
  }
  EXPECT_GT(num_unseen, 100);
  const PlaneMaps alone = Refine(scene_, {{}, {}, {}, {}}, options_, seed);
  EXPECT_EQ(alone.distinctness, std::vector<float>(67 * 48, 0.0f));
}

TEST_P(PatchMatchTest, OutsideOfTheSourceNothingChanges) {
  // Sees the left of the wall only.
  View& source = scene_.views[1];
  source = MakeView("far left", source.camera, Eigen::Vector3d(-2.0, 0, 0));
  plane_.Photograph(67, 48, &source);
  const PlaneMaps seed = Seed(1.03f);
  const PlaneMaps result = Refine(scene_, {{1}, {}, {}, {}}, options_, seed);
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
  const PlaneMaps result = Refine(scene_, {{1}, {}, {}, {}}, options_, seed);
  EXPECT_TRUE(SamePlanes(result, seed));
  EXPECT_EQ(result.cost, std::vector<float>(67 * 48, 2.0f));
}

TEST_P(PatchMatchTest, WithoutSourcesNothingChanges) {
  const PlaneMaps seed = Seed(1.03f);
  for (const Sources& sources :
       {Sources{{}, {}, {}, {}}, Sources{{}, {0, 2}, {0}, {0}}}) {
    const PlaneMaps result = Refine(scene_, sources, options_, seed);
    EXPECT_TRUE(SamePlanes(result, seed));
    EXPECT_EQ(result.cost, std::vector<float>(67 * 48, 2.0f));
  }
}

TEST_P(PatchMatchTest, PixelsWithoutSeedStayAndDoNotSpread) {
  options_.prior_weight = 0;
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
      const PlaneMaps seed = MakePlanes(plane_, view, MakeFrame().scale);
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
  const Scene scene = MakeSlantedScene(&plane);
  PlaneMaps seed = MakePlanes(plane, scene.views[0], MakeFrame().scale);
  for (float& rho : seed.rho) {
    rho *= 1.02f;
  }
  const auto run = [&] {
    return Refine(scene, kAllSources, StereoOptions(), seed);
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
  const Scene scene = MakeSlantedScene(&plane);
  const SceneFrame frame = MakeFrame();
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
  const Scene scene = MakeSlantedScene(&plane);
  const PlaneMaps seed = MakePlanes(plane, scene.views[0], MakeFrame().scale);
  const auto sources = [](const size_t count) {
    return Sources{std::vector<int>(count, 1), {}, {}, {}};
  };
  EXPECT_THROW(Refine(scene, sources(33), StereoOptions(), seed),
               std::invalid_argument);
  StereoOptions options;
  options.num_used_sources = 32;
  options.num_best_sources = 32;
  EXPECT_FALSE(SamePlanes(Refine(scene, sources(32), options, seed), seed));
}

}  // namespace
}  // namespace structnerf
