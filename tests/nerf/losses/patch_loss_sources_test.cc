// Which source views count. Values and gradients are in patch_loss_test.cc.

#include "nerf/losses/patch_loss.h"
#include "tests/nerf/losses/patch_scene.h"
#include "tests/nerf/plane_scene.h"
#include "tests/nerf/simd_targets.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

namespace structnerf {
namespace {

class PatchLossSourcesTest : public SimdTargetTest {};

TEST_P(PatchLossSourcesTest, TapsOutsideTheSourceMakeItInvalid) {
  Scene scene = MakeStereoPair(2);
  scene.views[0].image = PlainImage(32, 24, 100);
  scene.views[1].image = PlainImage(32, 24, 100);
  const PatchLoss::Options options;  // reaches two pixels
  std::vector<PatchPixel> pixels;
  for (int col = 0; col < 32; ++col) {
    pixels.push_back({0, col, 12});
  }
  // Half a pixel further to the left than at 1 m.
  const PatchResult result = EvaluatePatches(
      scene, {{1}, {0}}, options, pixels, std::vector<double>(32, 0.8));
  for (int col = 0; col < 32; ++col) {
    // Taps col - 2 .. col + 2 land 2.5 pixels to the left.
    const bool is_inside = col - 2 - 2.5 >= 0;
    EXPECT_EQ(result.num_valid[col], is_inside ? 1 : 0) << col;
    EXPECT_NEAR(result.loss[col], 0, 1e-6) << col;
  }
}

TEST_P(PatchLossSourcesTest, SourceThatLooksAwayIsInvalid) {
  TexturedPlane plane;
  Scene scene;
  const PinholeCamera camera = MakeCamera(32, 24, 20);
  // The second camera stands behind the wall and looks on; a projection that
  // forgets the sign of the depth puts the wall into its image.
  scene.views = {MakeView("front", camera, Eigen::Vector3d(0, 0, 0)),
                 MakeView("behind", camera, Eigen::Vector3d(0.1, 0, 8)),
                 MakeView("beside", camera, Eigen::Vector3d(0.2, 0, 0))};
  for (View& view : scene.views) {
    plane.Photograph(32, 24, &view);
  }
  const PatchLoss::Options options;
  EXPECT_EQ(EvaluatePatches(scene, {{1}, {}, {}}, options, {{0, 16, 12}}, {4})
                .num_valid[0],
            0);
  EXPECT_EQ(
      EvaluatePatches(scene, {{1, 2}, {}, {}}, options, {{0, 16, 12}}, {4})
          .num_valid[0],
      1);
}

TEST_P(PatchLossSourcesTest, MaskedTapsOfTheSourceMakeItInvalid) {
  Scene scene = MakeStereoPair(2);
  scene.views[0].image = PlainImage(32, 24, 100);
  scene.views[1].image = PlainImage(32, 24, 100);
  const PatchLoss::Options options;
  for (int row = 8; row < 18; ++row) {
    for (int col = 8; col < 22; ++col) {
      scene.views[1].mask.assign(32 * 24, 255);
      scene.views[1].mask[row * 32 + col] = 0;
      const PatchResult result =
          EvaluatePatches(scene, {{1}, {0}}, options, {{0, 16, 12}}, {0.8});
      // Taps land at columns 11.5, 13.5 and 15.5, so pixels 11 to 16 are read
      // in rows 10, 12 and 14 (and the next ones, with no weight).
      const bool is_read = col >= 11 && col <= 16 && row >= 10 && row <= 15;
      EXPECT_EQ(result.num_valid[0], is_read ? 0 : 1) << col << " " << row;
    }
  }
}

TEST_P(PatchLossSourcesTest, MaskedTapsOfTheViewMakeAllSourcesInvalid) {
  Scene scene = MakeStereoPair(2);
  scene.views[0].image = PlainImage(32, 24, 100);
  scene.views[1].image = PlainImage(32, 24, 100);
  scene.views[0].mask.assign(32 * 24, 255);
  scene.views[0].mask[12 * 32 + 16] = 0;
  std::vector<PatchPixel> pixels;
  for (int row = 8; row < 17; ++row) {
    for (int col = 12; col < 21; ++col) {
      pixels.push_back({0, col, row});
    }
  }
  const PatchResult result =
      EvaluatePatches(scene,
                      {{1}, {0}},
                      PatchLoss::Options(),
                      pixels,
                      std::vector<double>(pixels.size(), 0.8));
  for (size_t i = 0; i < pixels.size(); ++i) {
    const int dx = std::abs(pixels[i].col - 16);
    const int dy = std::abs(pixels[i].row - 12);
    const bool is_read = (dx == 0 || dx == 2) && (dy == 0 || dy == 2);
    EXPECT_EQ(result.num_valid[i], is_read ? 0 : 1)
        << pixels[i].col << " " << pixels[i].row;
  }
}

// At the border of its own image a patch moves inside rather than compare
// pixels that are not there.
TEST_P(PatchLossSourcesTest, BorderPixelsAreComparedLikeOthers) {
  TexturedPlane plane;
  plane.wavelength = 1.2;
  Scene scene;
  // The source sees more of the wall to all sides.
  scene.views = {MakeView("narrow", MakeCamera(40, 30, 60), {0, 0, 0}),
                 MakeView("wide", MakeCamera(80, 60, 60), {0.1, 0.05, 0})};
  plane.Photograph(40, 30, &scene.views[0]);
  plane.Photograph(80, 60, &scene.views[1]);
  PatchLoss::Options options;
  for (const int radius : {1, 3}) {
    options.radius = radius;
    std::vector<PatchPixel> pixels;
    for (int col = 0; col < 40; ++col) {
      pixels.push_back({0, col, 0});
      pixels.push_back({0, col, 29});
    }
    for (int row = 0; row < 30; ++row) {
      pixels.push_back({0, 0, row});
      pixels.push_back({0, 39, row});
    }
    const PatchResult right =
        EvaluatePatches(scene,
                        {{1}, {}},
                        options,
                        pixels,
                        std::vector<double>(pixels.size(), 4));
    const PatchResult wrong =
        EvaluatePatches(scene,
                        {{1}, {}},
                        options,
                        pixels,
                        std::vector<double>(pixels.size(), 2.5));
    for (size_t i = 0; i < pixels.size(); ++i) {
      ASSERT_EQ(right.num_valid[i], 1);
      EXPECT_LT(right.loss[i], 0.02);
      EXPECT_GT(wrong.loss[i], 3 * right.loss[i]);
    }
  }
}

TEST_P(PatchLossSourcesTest, ImagesSmallerThanThePatchAreInvalid) {
  Scene scene = MakeStereoPair(0);
  scene.views[0].camera = MakeCamera(5, 4, 100);
  scene.views[0].image = PlainImage(5, 4, 100);
  scene.views[1].image = PlainImage(32, 24, 100);
  PatchLoss::Options options;  // five pixels wide and high
  EXPECT_EQ(
      EvaluatePatches(scene, {{1}, {}}, options, {{0, 2, 2}}, {1}).num_valid[0],
      0);
  options.dilation = 1;
  EXPECT_EQ(
      EvaluatePatches(scene, {{1}, {}}, options, {{0, 2, 2}}, {1}).num_valid[0],
      1);
}

TEST_P(PatchLossSourcesTest, BestSourcesAreThoseWithTheSmallestLoss) {
  Scene scene = MakeStereoPair(2);
  const PinholeCamera camera = scene.views[0].camera;
  scene.views[0].image = PlainImage(32, 24, 100);
  // Grey differences of 80, 20, 0, 40 and a view that does not see the pixel.
  scene.views.resize(1);
  for (const int value : {180, 120, 100, 60}) {
    scene.views.push_back(
        MakeView("source", camera, Eigen::Vector3d(0.02, 0, 0)));
    scene.views.back().image = PlainImage(32, 24, static_cast<uint8_t>(value));
  }
  scene.views.push_back(MakeView("off", camera, Eigen::Vector3d(5, 0, 0)));
  scene.views.back().image = PlainImage(32, 24, 100);
  const PatchSources sources = {{1, 5, 2, 3, 4}, {}, {}, {}, {}, {}};
  PatchLoss::Options options;
  options.ssim_share = 0;
  const double expected[] = {0, 10, 20, 35, 35, 35};
  for (int num_best = 1; num_best <= 6; ++num_best) {
    options.num_best = num_best;
    const PatchResult result =
        EvaluatePatches(scene, sources, options, {{0, 16, 12}}, {1.0});
    EXPECT_NEAR(result.loss[0], expected[num_best - 1] / 255, 1e-5);
    EXPECT_EQ(result.num_valid[0], 4);
  }
}

TEST_P(PatchLossSourcesTest, NoSources) {
  Scene scene = MakeStereoPair(2);
  scene.views[0].image = PlainImage(32, 24, 1);
  scene.views[1].image = PlainImage(32, 24, 255);
  const PatchResult result = EvaluatePatches(scene,
                                             {{}, {}},
                                             PatchLoss::Options(),
                                             {{0, 16, 12}, {1, 16, 12}},
                                             {1.0, 1.0});
  for (int i = 0; i < 2; ++i) {
    EXPECT_EQ(result.num_valid[i], 0);
    EXPECT_EQ(result.loss[i], 0);
    EXPECT_EQ(result.d_depth[i], 0);
  }
}

// Extreme depths and images of a single pixel give finite numbers.
TEST_P(PatchLossSourcesTest, ExtremesStayFinite) {
  TexturedPlane plane;
  Scene scene = MakeSlantedScene(&plane);
  scene.views.push_back(
      MakeView("dot", MakeCamera(1, 1, 1), Eigen::Vector3d(0.1, 0, 0)));
  scene.views.back().image = PlainImage(1, 1, 50);
  const PatchSources sources = {{1, 2, 3}, {0, 3}, {1, 3}, {0, 1, 2}};
  std::vector<PatchPixel> pixels;
  std::vector<double> depths;
  for (const double depth : {1e-6, 1e-3, 0.3, 1e3, 1e9}) {
    for (int view_idx = 0; view_idx < 4; ++view_idx) {
      pixels.push_back({view_idx, 0, 0});
      pixels.push_back({view_idx,
                        scene.views[view_idx].image.width / 2,
                        scene.views[view_idx].image.height / 2});
      depths.insert(depths.end(), {depth, depth});
    }
  }
  const PatchResult result =
      EvaluatePatches(scene, sources, PatchLoss::Options(), pixels, depths);
  for (size_t i = 0; i < pixels.size(); ++i) {
    EXPECT_TRUE(std::isfinite(result.loss[i]));
    EXPECT_TRUE(std::isfinite(result.d_depth[i]));
    EXPECT_GE(result.loss[i], 0);
    EXPECT_LE(result.loss[i], 1);
  }
}

STRUCTNERF_FOR_EACH_SIMD_TARGET(PatchLossSourcesTest);

TEST(PatchLossLimits, MoreSourcesThanThereIsRoomForAreRefused) {
  Scene scene = MakeStereoPair(2);
  scene.views[0].image = PlainImage(32, 24, 1);
  scene.views[1].image = PlainImage(32, 24, 1);
  const PatchSources sources = {std::vector<int>(33, 1), {}};
  EXPECT_THROW(EvaluatePatches(
                   scene, sources, PatchLoss::Options(), {{0, 16, 12}}, {1.0}),
               std::invalid_argument);
}

}  // namespace
}  // namespace structnerf
