#include "nerf/losses/patch_loss.h"

#include "nerf/util/random.h"
#include "tests/nerf/losses/patch_loss_reference.h"
#include "tests/nerf/plane_scene.h"
#include "tests/nerf/simd_targets.h"
#include "tests/support/numeric_gradient.h"

#include <cmath>
#include <stdexcept>
#include <vector>

namespace structnerf {
namespace {

using Sources = std::vector<std::vector<int>>;

struct Pixel {
  int view_idx = 0;
  int col = 0;
  int row = 0;
};

struct Result {
  std::vector<float> loss;
  std::vector<float> d_depth;  // by depth in world units
  std::vector<int> num_valid;
};

// Field coordinates of a scene that is not where the world's origin is, so that
// a forgotten conversion shows.
SceneFrame MakeFrame() {
  SceneFrame frame;
  frame.origin = Eigen::Vector3d(-3, -2, -1);
  frame.scale = 0.125;
  return frame;
}

// `depths` in world units.
Result Evaluate(const Scene& scene,
                const Sources& sources,
                const PatchLoss::Options& options,
                const std::vector<Pixel>& pixels,
                const std::vector<double>& depths) {
  const SceneFrame frame = MakeFrame();
  const TrainingViews views(scene, frame);
  const PatchLoss patch_loss(scene, frame, views, sources, options);
  std::vector<int> view_idx;
  std::vector<int> col;
  std::vector<int> row;
  std::vector<float> depth;
  for (size_t i = 0; i < pixels.size(); ++i) {
    view_idx.push_back(pixels[i].view_idx);
    col.push_back(pixels[i].col);
    row.push_back(pixels[i].row);
    depth.push_back(static_cast<float>(depths[i] * frame.scale));
  }
  Result result;
  // What must be overwritten.
  result.loss.assign(pixels.size(), -7.0f);
  result.d_depth.assign(pixels.size(), -7.0f);
  result.num_valid.assign(pixels.size(), -7);
  patch_loss.Evaluate(static_cast<int>(pixels.size()),
                      view_idx.data(),
                      col.data(),
                      row.data(),
                      depth.data(),
                      result.loss.data(),
                      result.d_depth.data(),
                      result.num_valid.data());
  for (float& derivative : result.d_depth) {
    derivative *= static_cast<float>(frame.scale);
  }
  return result;
}

// Two views side by side, one metre in front of a wall, the second displaced by
// exactly `shift` pixels of disparity: f b / z = 100 * 0.01 shift / 1.
Scene MakeStereoPair(const double shift) {
  Scene scene;
  const PinholeCamera camera = MakeCamera(32, 24, 100);
  scene.views = {
      MakeView("left", camera, Eigen::Vector3d::Zero()),
      MakeView("right", camera, Eigen::Vector3d(0.01 * shift, 0, 0))};
  return scene;
}

// Three views of a slanted textured wall with different cameras and sizes; the
// last one's image is half its camera's size.
Scene MakeSlantedScene(TexturedPlane* plane) {
  plane->normal = Eigen::Vector3d(0.3, -0.2, -1);
  plane->wavelength = 0.9;
  Scene scene;
  scene.views = {
      MakeView("a", MakeCamera(48, 36, 50), Eigen::Vector3d(0, 0, 0)),
      MakeView("b",
               {56, 40, 61, 58, 26, 21.5},
               Eigen::Vector3d(0.4, 0.1, 0.3),
               Eigen::Vector3d(-0.1, 0.02, 1)),
      MakeView("c",
               MakeCamera(96, 80, 97),
               Eigen::Vector3d(-0.35, 0.2, -0.2),
               Eigen::Vector3d(0.08, -0.05, 1))};
  plane->Photograph(48, 36, &scene.views[0]);
  plane->Photograph(56, 40, &scene.views[1]);
  plane->Photograph(48, 40, &scene.views[2]);
  return scene;
}

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
    const Result result =
        Evaluate(scene, {{1}, {0}}, options, {{0, 16, 12}}, {1.0});
    ASSERT_EQ(result.num_valid[0], 1);
    // Without any structure: SSIM = (2 0.2 0.4 + c1) / (0.2^2 + 0.4^2 + c1).
    const double ssim = 0.1601 / 0.2001;
    EXPECT_NEAR(result.loss[0], 0.85 * 0.5 * (1 - ssim) + 0.15 * 0.2, 1e-5);
    EXPECT_NEAR(result.d_depth[0], 0, 1e-6);
    options.ssim_share = 0;
    EXPECT_NEAR(
        Evaluate(scene, {{1}, {0}}, options, {{0, 16, 12}}, {1.0}).loss[0],
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
  const Result result =
      Evaluate(scene, {{1}, {0}}, options, {{0, 16, 12}}, {0.8});
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
  std::vector<Pixel> pixels;
  for (int row = 2; row < 21; ++row) {
    for (int col = 5; col < 29; ++col) {
      pixels.push_back({0, col, row});
    }
  }
  // A hair's breadth in front, since exactly on the pixels the last column or
  // row may lie a rounding outside.
  const Result result = Evaluate(scene,
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
  const Sources sources = {{1, 2}, {0, 2}, {0, 1}};
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
        const Result result =
            Evaluate(scene,
                     sources,
                     PatchLoss::Options(),
                     std::vector<Pixel>(ratios.size(), {view_idx, col, row}),
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
  const Sources sources = {{1, 2}, {2, 0}, {1}};
  Random random(3);
  int num_values = 0;
  int num_gradients = 0;
  for (int round = 0; round < 24; ++round) {
    PatchLoss::Options options;
    options.radius = static_cast<int>(random.NextBelow(4));
    options.dilation = 1 + static_cast<int>(random.NextBelow(3));
    options.ssim_share = random.NextFloat();
    options.num_best = 1 + static_cast<int>(random.NextBelow(2));
    std::vector<Pixel> pixels;
    std::vector<double> depths;
    for (int i = 0; i < 40; ++i) {
      const int view_idx = static_cast<int>(random.NextBelow(3));
      const RgbImage& image = scene.views[view_idx].image;
      pixels.push_back({view_idx,
                        static_cast<int>(random.NextBelow(image.width)),
                        static_cast<int>(random.NextBelow(image.height))});
      depths.push_back(3 + 2 * random.NextFloat());
    }
    const Result result = Evaluate(scene, sources, options, pixels, depths);
    for (size_t i = 0; i < pixels.size(); ++i) {
      const Pixel& pixel = pixels[i];
      // The loss is evaluated where float has put the depth.
      const double scale = MakeFrame().scale;
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
      EXPECT_LE(result.num_valid[i], options.num_best);
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

TEST_P(PatchLossTest, TapsOutsideTheSourceMakeItInvalid) {
  Scene scene = MakeStereoPair(2);
  scene.views[0].image = PlainImage(32, 24, 100);
  scene.views[1].image = PlainImage(32, 24, 100);
  const PatchLoss::Options options;  // reaches two pixels
  std::vector<Pixel> pixels;
  for (int col = 0; col < 32; ++col) {
    pixels.push_back({0, col, 12});
  }
  // Half a pixel further to the left than at 1 m.
  const Result result = Evaluate(
      scene, {{1}, {0}}, options, pixels, std::vector<double>(32, 0.8));
  for (int col = 0; col < 32; ++col) {
    // Taps col - 2 .. col + 2 land 2.5 pixels to the left.
    const bool is_inside = col - 2 - 2.5 >= 0;
    EXPECT_EQ(result.num_valid[col], is_inside ? 1 : 0) << col;
    EXPECT_NEAR(result.loss[col], 0, 1e-6) << col;
  }
}

TEST_P(PatchLossTest, SourceThatLooksAwayIsInvalid) {
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
  EXPECT_EQ(
      Evaluate(scene, {{1}, {}, {}}, options, {{0, 16, 12}}, {4}).num_valid[0],
      0);
  EXPECT_EQ(Evaluate(scene, {{1, 2}, {}, {}}, options, {{0, 16, 12}}, {4})
                .num_valid[0],
            1);
}

TEST_P(PatchLossTest, MaskedTapsOfTheSourceMakeItInvalid) {
  Scene scene = MakeStereoPair(2);
  scene.views[0].image = PlainImage(32, 24, 100);
  scene.views[1].image = PlainImage(32, 24, 100);
  const PatchLoss::Options options;
  for (int row = 8; row < 18; ++row) {
    for (int col = 8; col < 22; ++col) {
      scene.views[1].mask.assign(32 * 24, 255);
      scene.views[1].mask[row * 32 + col] = 0;
      const Result result =
          Evaluate(scene, {{1}, {0}}, options, {{0, 16, 12}}, {0.8});
      // Taps land at columns 11.5, 13.5 and 15.5, so pixels 11 to 16 are read
      // in rows 10, 12 and 14 (and the next ones, with no weight).
      const bool is_read = col >= 11 && col <= 16 && row >= 10 && row <= 15;
      EXPECT_EQ(result.num_valid[0], is_read ? 0 : 1) << col << " " << row;
    }
  }
}

TEST_P(PatchLossTest, MaskedTapsOfTheViewMakeAllSourcesInvalid) {
  Scene scene = MakeStereoPair(2);
  scene.views[0].image = PlainImage(32, 24, 100);
  scene.views[1].image = PlainImage(32, 24, 100);
  scene.views[0].mask.assign(32 * 24, 255);
  scene.views[0].mask[12 * 32 + 16] = 0;
  std::vector<Pixel> pixels;
  for (int row = 8; row < 17; ++row) {
    for (int col = 12; col < 21; ++col) {
      pixels.push_back({0, col, row});
    }
  }
  const Result result = Evaluate(scene,
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
TEST_P(PatchLossTest, BorderPixelsAreComparedLikeOthers) {
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
    std::vector<Pixel> pixels;
    for (int col = 0; col < 40; ++col) {
      pixels.push_back({0, col, 0});
      pixels.push_back({0, col, 29});
    }
    for (int row = 0; row < 30; ++row) {
      pixels.push_back({0, 0, row});
      pixels.push_back({0, 39, row});
    }
    const Result right = Evaluate(scene,
                                  {{1}, {}},
                                  options,
                                  pixels,
                                  std::vector<double>(pixels.size(), 4));
    const Result wrong = Evaluate(scene,
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

TEST_P(PatchLossTest, ImagesSmallerThanThePatchAreInvalid) {
  Scene scene = MakeStereoPair(0);
  scene.views[0].camera = MakeCamera(5, 4, 100);
  scene.views[0].image = PlainImage(5, 4, 100);
  scene.views[1].image = PlainImage(32, 24, 100);
  PatchLoss::Options options;  // five pixels wide and high
  EXPECT_EQ(Evaluate(scene, {{1}, {}}, options, {{0, 2, 2}}, {1}).num_valid[0],
            0);
  options.dilation = 1;
  EXPECT_EQ(Evaluate(scene, {{1}, {}}, options, {{0, 2, 2}}, {1}).num_valid[0],
            1);
}

TEST_P(PatchLossTest, BestSourcesAreThoseWithTheSmallestLoss) {
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
  const Sources sources = {{1, 5, 2, 3, 4}, {}, {}, {}, {}, {}};
  PatchLoss::Options options;
  options.ssim_share = 0;
  const double expected[] = {0, 10, 20, 35, 35, 35};
  for (int num_best = 1; num_best <= 6; ++num_best) {
    options.num_best = num_best;
    const Result result =
        Evaluate(scene, sources, options, {{0, 16, 12}}, {1.0});
    EXPECT_NEAR(result.loss[0], expected[num_best - 1] / 255, 1e-5);
    EXPECT_EQ(result.num_valid[0], std::min(num_best, 4));
  }
}

TEST_P(PatchLossTest, NoSources) {
  Scene scene = MakeStereoPair(2);
  scene.views[0].image = PlainImage(32, 24, 1);
  scene.views[1].image = PlainImage(32, 24, 255);
  const Result result = Evaluate(scene,
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
TEST_P(PatchLossTest, ExtremesStayFinite) {
  TexturedPlane plane;
  Scene scene = MakeSlantedScene(&plane);
  scene.views.push_back(
      MakeView("dot", MakeCamera(1, 1, 1), Eigen::Vector3d(0.1, 0, 0)));
  scene.views.back().image = PlainImage(1, 1, 50);
  const Sources sources = {{1, 2, 3}, {0, 3}, {1, 3}, {0, 1, 2}};
  std::vector<Pixel> pixels;
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
  const Result result =
      Evaluate(scene, sources, PatchLoss::Options(), pixels, depths);
  for (size_t i = 0; i < pixels.size(); ++i) {
    EXPECT_TRUE(std::isfinite(result.loss[i]));
    EXPECT_TRUE(std::isfinite(result.d_depth[i]));
    EXPECT_GE(result.loss[i], 0);
    EXPECT_LE(result.loss[i], 1);
  }
}

STRUCTNERF_FOR_EACH_SIMD_TARGET(PatchLossTest);

// The same rays give the same numbers with every instruction set.
TEST(PatchLossTargets, Agree) {
  TexturedPlane plane;
  const Scene scene = MakeSlantedScene(&plane);
  const Sources sources = {{1, 2}, {0, 2}, {1, 0}};
  Random random(9);
  std::vector<Pixel> pixels;
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
    return Evaluate(scene, sources, PatchLoss::Options(), pixels, depths);
  };
  const Result expected = run();
  for (const int64_t target : hwy::SupportedAndGeneratedTargets()) {
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    const Result result = run();
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

TEST(PatchLossLimits, MoreSourcesThanThereIsRoomForAreRefused) {
  Scene scene = MakeStereoPair(2);
  scene.views[0].image = PlainImage(32, 24, 1);
  scene.views[1].image = PlainImage(32, 24, 1);
  const Sources sources = {std::vector<int>(33, 1), {}};
  EXPECT_THROW(
      Evaluate(scene, sources, PatchLoss::Options(), {{0, 16, 12}}, {1.0}),
      std::invalid_argument);
}

}  // namespace
}  // namespace structnerf
