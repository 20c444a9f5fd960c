#include "nerf/train/trainer.h"
#include "tests/nerf/train/trainer_fixture.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

namespace structnerf {
namespace {

TEST_F(TrainerTest, HeldOutPsnr) {
  scene_.views[1].image = PlainImage(16, 12, 102);
  // 0.3 against 0.4 in every channel.
  engine_.color.setConstant(0.3f);
  const TrainingSummary summary = Run({1});
  EXPECT_NEAR(summary.held_out_psnr, 20, 1e-3);
  EXPECT_EQ(progress_.updates.front().held_out_psnr, -1);
  EXPECT_NEAR(progress_.updates.back().held_out_psnr, 20, 1e-3);
  // Now and then on the way.
  EXPECT_NEAR(
      progress_.updates[progress_.updates.size() / 2].held_out_psnr, 20, 1e-3);
}

TEST_F(TrainerTest, HeldOutPsnrKnowsTheExposure) {
  scene_.views[1].image = PlainImage(16, 12, 102);
  scene_.views[1].exposure.gain.setConstant(0.5f);
  scene_.views[1].exposure.offset.setConstant(0.15f);
  engine_.color.setConstant(0.3f);
  EXPECT_NEAR(Run({1}).held_out_psnr, 20, 1e-3);
}

TEST_F(TrainerTest, WithoutHeldOutViewsSinglePixelsAreMeasured) {
  engine_.color.setConstant(0.3f);
  // Only pixel (8, 8) is held out of these images: 0.3 against 0.4.
  for (View& view : scene_.views) {
    for (int c = 0; c < 3; ++c) {
      view.image.data[3 * (8 * 16 + 8) + c] = 102;
    }
  }
  EXPECT_NEAR(Run().held_out_psnr, 20, 1e-3);
  // Nothing is left to measure if it is masked.
  for (View& view : scene_.views) {
    view.mask.assign(16 * 12, 255);
    view.mask[8 * 16 + 8] = 0;
  }
  EXPECT_EQ(Run().held_out_psnr, -1);
}

// More pixels than are measured: a fair choice of them.
TEST_F(TrainerTest, LargeViewsAreSampledEvenly) {
  View& view = scene_.views[1];
  view.camera = MakeCamera(400, 300, 300);
  view.image = PlainImage(400, 300, 0);
  // The right half is white: half of the pixels are entirely wrong.
  for (int row = 0; row < 300; ++row) {
    std::fill_n(view.image.data.begin() + 3 * (row * 400 + 200), 600, 255);
  }
  scene_.points = {MakePoint(scene_, {0, 0, 4}, {0, 1, 2})};
  engine_.color.setZero();
  const double expected = -10 * std::log10(0.5);
  EXPECT_NEAR(Run({1}).held_out_psnr, expected, 0.15);
  EXPECT_LE(engine_.num_rendered_rays, 20u * 8192);
  EXPECT_GE(engine_.num_rendered_rays, 10u * 8192);
}

TEST_F(TrainerTest, PerfectPicturesHaveAFinitePsnr) {
  scene_.views[1].image = PlainImage(16, 12, 255);
  engine_.color.setOnes();
  EXPECT_NEAR(Run({1}).held_out_psnr, 120, 1e-3);
}

TEST_F(TrainerTest, MaskedPixelsAreNotCompared) {
  View& view = scene_.views[1];
  view.image = PlainImage(16, 12, 102);
  view.mask.assign(16 * 12, 255);
  for (int i = 0; i < 100; ++i) {
    view.mask[i] = 0;
    for (int c = 0; c < 3; ++c) {
      view.image.data[3 * i + c] = 255;
    }
  }
  engine_.color.setConstant(0.3f);
  EXPECT_NEAR(Run({1}).held_out_psnr, 20, 1e-3);
  // Nothing left to compare.
  view.mask.assign(16 * 12, 0);
  EXPECT_EQ(Run({1}).held_out_psnr, -1);
}

}  // namespace
}  // namespace structnerf
