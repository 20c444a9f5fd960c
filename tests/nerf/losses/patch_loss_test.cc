// Values and gradients. Which sources count is in patch_loss_sources_test.cc.

#include "nerf/losses/patch_loss.h"

#include "nerf/util/random.h"
#include "tests/nerf/losses/patch_loss_reference.h"
#include "tests/nerf/losses/patch_scene.h"
#include "tests/nerf/plane_scene.h"
#include "tests/nerf/simd_targets.h"

#include <cmath>
#include <optional>
#include <vector>

namespace structnerf {
namespace {

class PatchLossTest : public SimdTargetTest {};

TEST_P(PatchLossTest, PlainImagesByHand) {
  Scene scene = MakeStereoPair(2);
  scene.views[0].image = PlainImage(32, 24, 51);   // 0.2
  scene.views[1].image = PlainImage(32, 24, 102);  // 0.4
  PatchLoss::Options options;
  for (const int radius : {0, 1, 3}) {
    options.radius = radius;
    options.dilation = 1;
    options.ssim_share = 0.85f;
    const PatchResult result =
        EvaluatePatches(scene, {{1}, {0}}, options, {{0, 16, 12}}, {1.0});
    ASSERT_EQ(result.num_valid[0], 1);
    // Without any structure: SSIM = (2 0.2 0.4 + c1) / (0.2^2 + 0.4^2 + c1).
    const double ssim = 0.1601 / 0.2001;
    EXPECT_NEAR(result.loss[0], 0.85 * 0.5 * (1 - ssim) + 0.15 * 0.2, 1e-5);
    EXPECT_NEAR(result.d_depth[0], 0, 1e-6);
    options.ssim_share = 0;
    EXPECT_NEAR(
        EvaluatePatches(scene, {{1}, {0}}, options, {{0, 16, 12}}, {1.0})
            .loss[0],
        0.2,
        1e-5);
  }
}

// A ramp of two grey levels per pixel: L1 is linear in the disparity.
TEST_P(PatchLossTest, RampByHand) {
  Scene scene = MakeStereoPair(2);
  for (View& view : scene.views) {
    view.image = PlainImage(32, 24, 0);
    for (size_t i = 0; i < view.image.data.size(); ++i) {
      view.image.data[i] = static_cast<uint8_t>(2 * (i / 3 % 32));
    }
  }
  PatchLoss::Options options;
  options.ssim_share = 0;
  // At depth 1 m / 1.25 a pixel moves 2.5 to the left, so each tap is darker by
  // 5 levels; disparity is 2 / depth.
  const PatchResult result =
      EvaluatePatches(scene, {{1}, {0}}, options, {{0, 16, 12}}, {0.8});
  EXPECT_NEAR(result.loss[0], 5.0 / 255, 1e-5);
  EXPECT_NEAR(result.d_depth[0], -2 * 2 / (0.8 * 0.8) / 255, 1e-5);
}

TEST_P(PatchLossTest, ShiftByWholePixelsIsExact) {
  Scene scene = MakeStereoPair(3);
  Random random(1);
  scene.views[0].image = PlainImage(32, 24, 0);
  scene.views[1].image = PlainImage(32, 24, 0);
  for (int row = 0; row < 24; ++row) {
    for (int col = 0; col < 32; ++col) {
      for (int c = 0; c < 3; ++c) {
        const auto value = static_cast<uint8_t>(random.NextBelow(256));
        scene.views[0].image.data[3 * (row * 32 + col) + c] = value;
        if (col >= 3) {
          scene.views[1].image.data[3 * (row * 32 + col - 3) + c] = value;
        }
      }
    }
  }
  std::vector<PatchPixel> pixels;
  for (int row = 2; row < 21; ++row) {
    for (int col = 5; col < 29; ++col) {
      pixels.push_back({0, col, row});
    }
  }
  // A hair's breadth in front, since exactly on the pixels the last column or
  // row may lie a rounding outside.
  const PatchResult result =
      EvaluatePatches(scene,
                      {{1}, {0}},
                      PatchLoss::Options(),
                      pixels,
                      std::vector<double>(pixels.size(), 1.0));
  for (size_t i = 0; i < pixels.size(); ++i) {
    ASSERT_EQ(result.num_valid[i], 1) << pixels[i].col << " " << pixels[i].row;
    EXPECT_LT(result.loss[i], 1e-4);
  }
}

TEST_P(PatchLossTest, SmallestAtTheTrueDepth) {
  TexturedPlane plane;
  const Scene scene = MakeSlantedScene(&plane);
  const PatchSources sources = {{1, 2}, {0, 2}, {0, 1}};
  int num_tested = 0;
  for (int view_idx = 0; view_idx < 3; ++view_idx) {
    const View& view = scene.views[view_idx];
    const double scale =
        static_cast<double>(view.camera.width) / view.image.width;
    for (int row = 10; row < 30; row += 5) {
      for (int col = 12; col < 36; col += 6) {
        const double depth =
            plane.Depth(view, scale * (col + 0.5), scale * (row + 0.5));
        const std::vector<double> ratios = {0.8, 0.9, 1.0, 1.1, 1.25};
        std::vector<double> depths;
        for (const double ratio : ratios) {
          depths.push_back(ratio * depth);
        }
        const PatchResult result = EvaluatePatches(
            scene,
            sources,
            PatchLoss::Options(),
            std::vector<PatchPixel>(ratios.size(), {view_idx, col, row}),
            depths);
        if (result.num_valid[0] < 2 || result.num_valid[2] < 2 ||
            result.num_valid[4] < 2) {
          continue;
        }
        ++num_tested;
        EXPECT_LT(result.loss[2], 0.02);
        EXPECT_LT(result.loss[2], 0.5 * result.loss[1]);
        EXPECT_LT(result.loss[2], 0.5 * result.loss[3]);
        EXPECT_LT(result.loss[2], 0.5 * result.loss[0]);
        EXPECT_LT(result.loss[2], 0.5 * result.loss[4]);
        // Downhill leads to it.
        EXPECT_LT(result.d_depth[1], 0);
        EXPECT_GT(result.d_depth[3], 0);
      }
    }
  }
  EXPECT_GT(num_tested, 20);
}

// Values and derivatives at random pixels, depths and options against the
// double-precision formulas. Where visibility or the best sources change, or a
// kink of bilinear interpolation lies within the step, there is no derivative.
TEST_P(PatchLossTest, ValueAndGradientAreThoseOfTheFormulas) {
  TexturedPlane plane;
  const Scene scene = MakeSlantedScene(&plane);
  const PatchSources sources = {{1, 2}, {2, 0}, {1}};
  Random random(3);
  int num_values = 0;
  int num_gradients = 0;
  for (int round = 0; round < 24; ++round) {
    PatchLoss::Options options;
    options.radius = static_cast<int>(random.NextBelow(4));
    options.dilation = 1 + static_cast<int>(random.NextBelow(3));
    options.ssim_share = random.NextFloat();
    options.num_best = 1 + static_cast<int>(random.NextBelow(2));
    std::vector<PatchPixel> pixels;
    std::vector<double> depths;
    for (int i = 0; i < 40; ++i) {
      const int view_idx = static_cast<int>(random.NextBelow(3));
      const RgbImage& image = scene.views[view_idx].image;
      pixels.push_back({view_idx,
                        static_cast<int>(random.NextBelow(image.width)),
                        static_cast<int>(random.NextBelow(image.height))});
      depths.push_back(3 + 2 * random.NextFloat());
    }
    const PatchResult result =
        EvaluatePatches(scene, sources, options, pixels, depths);
    for (size_t i = 0; i < pixels.size(); ++i) {
      const PatchPixel& pixel = pixels[i];
      // The loss is evaluated where float has put the depth.
      const double scale = MakePatchFrame().scale;
      const double depth = static_cast<float>(depths[i] * scale) / scale;
      const auto loss = [&](const double at) {
        return ReferencePatchLoss(scene,
                                  options,
                                  pixel.view_idx,
                                  sources[pixel.view_idx],
                                  pixel.col,
                                  pixel.row,
                                  at);
      };
      const std::optional<double> expected = loss(depth);
      const double h = 1e-5;
      const std::optional<double> above = loss(depth + h);
      const std::optional<double> below = loss(depth - h);
      if (expected.has_value() != above.has_value() ||
          expected.has_value() != below.has_value()) {
        continue;
      }
      if (!expected) {
        EXPECT_EQ(result.num_valid[i], 0);
        EXPECT_EQ(result.loss[i], 0);
        EXPECT_EQ(result.d_depth[i], 0);
        continue;
      }
      EXPECT_GT(result.num_valid[i], 0);
      EXPECT_LE(result.num_valid[i],
                static_cast<int>(sources[pixel.view_idx].size()));
      EXPECT_NEAR(result.loss[i], *expected, 1e-4);
      ++num_values;
      const double right = (*above - *expected) / h;
      const double left = (*expected - *below) / h;
      if (std::abs(right - left) < 1e-3 * (0.1 + std::abs(right))) {
        EXPECT_NEAR(result.d_depth[i],
                    0.5 * (left + right),
                    2e-3 * (0.1 + std::abs(right)))
            << "pixel " << pixel.col << " " << pixel.row << " of view "
            << pixel.view_idx << " at " << depth;
        ++num_gradients;
      }
    }
  }
  EXPECT_GT(num_values, 300);
  EXPECT_GT(num_gradients, 0.9 * num_values);
}

STRUCTNERF_FOR_EACH_SIMD_TARGET(PatchLossTest);

// The same rays give the same numbers with every instruction set.
TEST(PatchLossTargets, Agree) {
  TexturedPlane plane;
  const Scene scene = MakeSlantedScene(&plane);
  const PatchSources sources = {{1, 2}, {0, 2}, {1, 0}};
  Random random(9);
  std::vector<PatchPixel> pixels;
  std::vector<double> depths;
  for (int i = 0; i < 500; ++i) {
    const int view_idx = static_cast<int>(random.NextBelow(3));
    const RgbImage& image = scene.views[view_idx].image;
    pixels.push_back({view_idx,
                      static_cast<int>(random.NextBelow(image.width)),
                      static_cast<int>(random.NextBelow(image.height))});
    depths.push_back(1 + 5 * random.NextFloat());
  }
  const auto run = [&] {
    return EvaluatePatches(
        scene, sources, PatchLoss::Options(), pixels, depths);
  };
  const PatchResult expected = run();
  for (const int64_t target : hwy::SupportedAndGeneratedTargets()) {
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    const PatchResult result = run();
    int num_different = 0;
    for (size_t i = 0; i < pixels.size(); ++i) {
      EXPECT_NEAR(result.loss[i], expected.loss[i], 1e-4)
          << hwy::TargetName(target);
      num_different += result.num_valid[i] != expected.num_valid[i];
    }
    EXPECT_EQ(num_different, 0) << hwy::TargetName(target);
  }
  hwy::SetSupportedTargetsForTest(0);
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
}

}  // namespace
}  // namespace structnerf
