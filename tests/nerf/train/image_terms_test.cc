// Terms of the training objective that look at the photographs: colour and
// patches.

#include "nerf/train/keypoints.h"
#include "nerf/train/training_objective.h"
#include "tests/nerf/train/objective_scene.h"
#include "tests/nerf/train/step_losses.h"

#include <algorithm>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

namespace structnerf {
namespace {

TEST(ImageTerms, ColorByHand) {
  ObjectiveScene test;
  OnlyColor(&test.loss);
  test.loss.color_weight = 2;
  // The mean over rays of the sum over channels, however many rays.
  for (const int rays_per_step : {32, 33, 64, 512}) {
    test.training.rays_per_step = rays_per_step;
    const LossValues losses = EvaluateStep(test, 0, [](RayOutputs* outputs) {
      for (int ray = 0; ray < kMaxTileRays; ++ray) {
        outputs->color[0][ray] += 0.1f;
        outputs->color[2][ray] -= 0.2f;
      }
    });
    EXPECT_NEAR(Value(losses, LossTerm::kColor), 2 * (0.01 + 0.04), 1e-6);
    EXPECT_EQ(Sum(losses), Value(losses, LossTerm::kColor));
  }
}

// What is rendered is compared as each photograph's exposure shows it.
TEST(ImageTerms, ColorKnowsTheExposure) {
  ObjectiveScene test;
  OnlyColor(&test.loss);
  for (View& view : test.scene.views) {
    view.exposure.gain = {2, 1, 0.5f};
    view.exposure.offset = {0, 0.25f, 0};
  }
  const TrainingObjective objective = test.MakeObjective();
  const auto tile_objective = objective.MakeTileObjective();
  RayTile rays;
  tile_objective->DrawRays(0, 0, &rays);
  RayOutputs outputs = test.TrueOutputs(rays);
  const Exposure& exposure = test.scene.views[0].exposure;
  for (int ray = 0; ray < rays.num_rays; ++ray) {
    for (int c = 0; c < 3; ++c) {
      outputs.color[c][ray] =
          (outputs.color[c][ray] - exposure.offset[c]) / exposure.gain[c];
    }
  }
  RayGradients gradients;
  EXPECT_NEAR(Sum(tile_objective->Evaluate(outputs, &gradients)), 0, 1e-9);

  for (int c = 0; c < 3; ++c) {
    SCOPED_TRACE(c);
    constexpr float kStep = 1e-2f;
    RayOutputs changed = outputs;
    changed.color[c][5] += kStep;
    gradients = RayGradients();
    const double loss = Sum(tile_objective->Evaluate(changed, &gradients));
    // The loss is quadratic and vanishes at the truth.
    EXPECT_NEAR(gradients.d_color[c][5], 2 * loss / kStep, 1e-6);
    EXPECT_GT(loss, 0);
  }
}

// Where PSNR is measured, nothing is learned about colour.
TEST(ImageTerms, HeldOutPixelsHaveNoColorLoss) {
  ObjectiveScene test;
  OnlyColor(&test.loss);
  test.training.test_every = 0;
  const TrainingObjective objective = test.MakeObjective();
  const auto tile_objective = objective.MakeTileObjective();
  int num_held_out = 0;
  for (int step = 0; step < 100; ++step) {
    for (int tile = 0; tile < objective.NumTiles(); ++tile) {
      RayTile rays;
      tile_objective->DrawRays(step, tile, &rays);
      RayOutputs outputs = test.TrueOutputs(rays);
      for (float& red : outputs.color[0]) {
        red += 0.1f;
      }
      RayGradients gradients;
      tile_objective->Evaluate(outputs, &gradients);
      for (int ray = 0; ray < rays.num_rays; ++ray) {
        const auto point = test.Identify(rays, ray);
        const bool is_held_out = objective.IsHeldOut(point.Col(), point.Row());
        num_held_out += is_held_out;
        EXPECT_EQ(gradients.d_color[0][ray] == 0, is_held_out);
      }
    }
  }
  EXPECT_GT(num_held_out, 0);
}

// As many rays as otherwise, but the patches are those around keypoints.
TEST(ImageTerms, PatchesAtKeypointsOnly) {
  ObjectiveScene test;
  test.loss.planar_weight = 0;
  test.loss.sparse_weight = 0;
  test.loss.prior_weight = 0;
  test.loss.far_weight = 0;
  test.loss.patch_sampling = "keypoints";
  const TrainingObjective objective = test.MakeObjective();
  const auto tile_objective = objective.MakeTileObjective();
  int num_patches = 0;
  for (int tile = 0; tile < objective.NumTiles(); ++tile) {
    RayTile rays;
    tile_objective->DrawRays(0, tile, &rays);
    RayOutputs outputs = test.TrueOutputs(rays);
    ScaleDepth(1.1f, &outputs);
    RayGradients gradients;
    tile_objective->Evaluate(outputs, &gradients);
    for (int ray = 0; ray < rays.num_rays; ++ray) {
      if (gradients.d_depth[ray] == 0) {
        continue;
      }
      ++num_patches;
      const auto point = test.Identify(rays, ray);
      const std::vector<uint32_t> keypoints =
          SelectKeypoints(objective.Views(), point.view_idx);
      EXPECT_EQ(
          std::count(keypoints.begin(),
                     keypoints.end(),
                     static_cast<uint32_t>(24 * point.Row() + point.Col())),
          1);
    }
  }
  EXPECT_GT(num_patches, objective.NumTiles());
  EXPECT_LE(num_patches, objective.NumTiles() * kMaxTileRays / 2);
}

// A single pixel says less than a patch, but something.
TEST(ImageTerms, SinglePixelsInsteadOfPatches) {
  ObjectiveScene test;
  test.loss.planar_weight = 0;
  test.loss.sparse_weight = 0;
  test.loss.prior_weight = 0;
  test.loss.far_weight = 0;
  const auto evaluate = [&](const float factor) {
    return Value(
        EvaluateStep(
            test, 0, [&](RayOutputs* outputs) { ScaleDepth(factor, outputs); }),
        LossTerm::kPatch);
  };
  const double patch = evaluate(1.1f);
  test.loss.patch_radius = 0;
  EXPECT_NE(evaluate(1.1f), patch);
  EXPECT_GT(evaluate(1.1f), 2 * evaluate(1.0f));
}

}  // namespace
}  // namespace structnerf
