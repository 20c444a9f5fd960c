// Values and derivatives of the training objective's terms. Which rays are
// drawn is in ray_drawer_test.cc.

#include "nerf/engine/grid_engine.h"
#include "nerf/train/keypoints.h"
#include "nerf/train/training_objective.h"
#include "nerf/util/random.h"
#include "tests/nerf/engine/random_scene.h"
#include "tests/nerf/train/objective_scene.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace structnerf {
namespace {

double Value(const LossValues& losses, const LossTerm term) {
  return losses[static_cast<size_t>(term)];
}

double Sum(const LossValues& losses) {
  return std::accumulate(losses.begin(), losses.end(), 0.0);
}

// Every term off but the colour.
void OnlyColor(LossOptions* options) {
  options->patch_weight = 0;
  options->planar_weight = 0;
  options->sparse_weight = 0;
  options->prior_weight = 0;
  options->far_weight = 0;
}

// Losses of one step, with outputs that differ from the truth by what `change`
// makes of them.
LossValues EvaluateStep(const ObjectiveScene& test,
                        const int step,
                        const std::function<void(RayOutputs*)>& change) {
  const TrainingObjective objective = test.MakeObjective();
  const auto tile_objective = objective.MakeTileObjective();
  LossValues sum = {};
  for (int tile = 0; tile < objective.NumTiles(); ++tile) {
    RayTile rays;
    tile_objective->DrawRays(step, tile, &rays);
    RayOutputs outputs = test.TrueOutputs(rays);
    change(&outputs);
    RayGradients gradients;
    const LossValues losses = tile_objective->Evaluate(outputs, &gradients);
    for (size_t term = 0; term < sum.size(); ++term) {
      sum[term] += losses[term];
    }
  }
  return sum;
}

void ScaleDepth(const float factor, RayOutputs* outputs) {
  for (float& depth : outputs->depth) {
    depth *= factor;
  }
}

TEST(TrainingLoss, TheTruthCostsNextToNothing) {
  const LossValues losses =
      EvaluateStep(ObjectiveScene(), 0, [](RayOutputs*) {});
  EXPECT_NEAR(Value(losses, LossTerm::kColor), 0, 1e-9);
  EXPECT_LT(Value(losses, LossTerm::kPatch), 0.02);
  EXPECT_GT(Value(losses, LossTerm::kPatch), 0);
  EXPECT_NEAR(Value(losses, LossTerm::kPlanar), 0, 1e-6);
  EXPECT_NEAR(Value(losses, LossTerm::kSparse), 0, 1e-9);
  // The wall is interpolated well.
  EXPECT_LT(Value(losses, LossTerm::kPrior), 1e-3);
}

TEST(TrainingLoss, ColorByHand) {
  ObjectiveScene test;
  OnlyColor(&test.loss);
  test.loss.color_weight = 2;
  // The mean over rays of the sum over channels, however many rays.
  for (const int rays_per_step : {32, 64, 512}) {
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
TEST(TrainingLoss, ColorKnowsTheExposure) {
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
TEST(TrainingLoss, HeldOutPixelsHaveNoColorLoss) {
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

// Two views agree on any depth of what is blank in both; a third may object.
TEST(TrainingLoss, WhatTwoViewsSeeIsPushedLess) {
  ObjectiveScene test;
  OnlyColor(&test.loss);
  test.loss.far_weight = 0.5;
  test.training.rays_per_step = kMaxTileRays;
  for (View& view : test.scene.views) {
    std::fill(view.image.data.begin(), view.image.data.end(), uint8_t{128});
  }
  for (const int num_views : {2, 3}) {
    SCOPED_TRACE(num_views);
    test.train_view_idxs.resize(num_views);
    std::iota(test.train_view_idxs.begin(), test.train_view_idxs.end(), 0);
    const TrainingObjective objective = test.MakeObjective();
    const auto tile_objective = objective.MakeTileObjective();
    int num_pushed[] = {0, 0, 0};  // not at all, less, fully
    for (int step = 0; step < 20; ++step) {
      RayTile rays;
      tile_objective->DrawRays(step, 0, &rays);
      const RayOutputs outputs = test.TrueOutputs(rays);
      RayGradients gradients;
      const LossValues losses = tile_objective->Evaluate(outputs, &gradients);
      double expected = 0;
      for (int ray = 0; ray < rays.num_rays; ++ray) {
        const double full = -0.5 / kMaxTileRays / outputs.depth[ray];
        const double share = gradients.d_depth[ray] / full;
        expected -= share * 0.5 / kMaxTileRays * std::log(outputs.depth[ray]);
        ++num_pushed[share == 0 ? 0 : share < 0.5 ? 1 : 2];
      }
      EXPECT_NEAR(Value(losses, LossTerm::kFar), expected, 1e-5);
    }
    EXPECT_GT(num_pushed[0], 0);
    EXPECT_GT(num_pushed[1], 0);
    EXPECT_EQ(num_pushed[2] > 0, num_views == 3);
  }
}

TEST(TrainingLoss, SparseByHand) {
  ObjectiveScene test;
  OnlyColor(&test.loss);
  test.loss.sparse_weight = 3;
  // All errors equal: each weighs exp(-1).
  for (SparsePoint& point : test.scene.points) {
    point.error = 0.7;
  }
  for (const int rays_per_step : {32, 256}) {
    test.training.rays_per_step = rays_per_step;
    // 10 % too far, and spread by 20 % of the point's depth.
    const LossValues losses = EvaluateStep(test, 0, [](RayOutputs* outputs) {
      for (int ray = 0; ray < kMaxTileRays; ++ray) {
        outputs->depth_variance[ray] =
            std::pow(0.2f * outputs->depth[ray], 2.0f);
        outputs->depth[ray] *= 1.1f;
      }
    });
    EXPECT_NEAR(Value(losses, LossTerm::kSparse),
                3 * std::exp(-1.0) * (0.01 + 0.04),
                2e-6);
  }
}

TEST(TrainingLoss, SquaredSparseByHand) {
  ObjectiveScene test;
  OnlyColor(&test.loss);
  test.loss.sparse_weight = 3;
  test.loss.sparse_form = "squared";
  for (SparsePoint& point : test.scene.points) {
    point.error = 0.7;
  }
  const float unit = static_cast<float>(test.frame.median_depth);
  const LossValues losses = EvaluateStep(test, 0, [&](RayOutputs* outputs) {
    for (int ray = 0; ray < kMaxTileRays; ++ray) {
      outputs->depth_variance[ray] = 0.1f;  // plays no role
      outputs->depth[ray] += 0.1f * unit;
    }
  });
  EXPECT_NEAR(
      Value(losses, LossTerm::kSparse), 3 * std::exp(-1.0) * 0.01, 2e-6);
}

// How light ends along the rays, as the engine would tell.
class UniformSamples {
 public:
  static constexpr int kNumSamples = 8;

  explicit UniformSamples(const RayTile& rays) {
    for (int ray = 0; ray < rays.num_rays; ++ray) {
      for (int i = 0; i <= kNumSamples; ++i) {
        edges_.push_back(rays.near[ray] +
                         (rays.far[ray] - rays.near[ray]) * i / kNumSamples);
      }
    }
    weight_.assign(rays.num_rays * kNumSamples, 1.0f / kNumSamples);
  }

  RaySamples Samples() const {
    return {kNumSamples, edges_.data(), weight_.data()};
  }

 private:
  std::vector<float> edges_;
  std::vector<float> weight_;
};

// Equal weights cost log(8) wherever the points are.
TEST(TrainingLoss, RayTerminationByHand) {
  ObjectiveScene test;
  OnlyColor(&test.loss);
  test.loss.sparse_weight = 3;
  test.loss.sparse_form = "kl";
  test.loss.sparse_fraction = 0.5;
  const TrainingObjective objective = test.MakeObjective();
  const auto tile_objective = objective.MakeTileObjective();
  double sum = 0;
  for (int tile = 0; tile < objective.NumTiles(); ++tile) {
    RayTile rays;
    tile_objective->DrawRays(0, tile, &rays);
    RayGradients gradients;
    const LossValues losses =
        tile_objective->Evaluate(test.TrueOutputs(rays), &gradients);
    EXPECT_EQ(Value(losses, LossTerm::kSparse), 0);
    ASSERT_TRUE(tile_objective->UsesSamples());
    const UniformSamples samples(rays);
    std::vector<float> d_weight(rays.num_rays * UniformSamples::kNumSamples);
    sum += Value(
        tile_objective->EvaluateSamples(samples.Samples(), d_weight.data()),
        LossTerm::kSparse);
    for (int ray = 0; ray < rays.num_rays; ++ray) {
      const auto begin = d_weight.begin() + ray * UniformSamples::kNumSamples;
      // Points lie off the pixels' centres.
      const bool is_sparse = !test.Identify(rays, ray).IsPixelCenter();
      EXPECT_EQ(std::any_of(begin,
                            begin + UniformSamples::kNumSamples,
                            [](const float d) { return d != 0; }),
                is_sparse);
    }
  }
  EXPECT_NEAR(sum, 3 * std::log(8.0), 1e-3);

  RayTile rays;
  tile_objective->DrawRays(50, 0, &rays);
  EXPECT_FALSE(tile_objective->UsesSamples());
}

TEST(TrainingLoss, OtherFormsUseNoSamples) {
  ObjectiveScene test;
  for (const char* const form : {"line_of_sight", "squared"}) {
    test.loss.sparse_form = form;
    const TrainingObjective objective = test.MakeObjective();
    const auto tile_objective = objective.MakeTileObjective();
    RayTile rays;
    tile_objective->DrawRays(0, 0, &rays);
    EXPECT_FALSE(tile_objective->UsesSamples()) << form;
  }
}

// Four corners of a unit step in depth: the triple product notices what leaves
// the plane, in units of the median depth, whatever the planar scale.
TEST(TrainingLoss, TripleProductOfTheWallVanishes) {
  ObjectiveScene test;
  OnlyColor(&test.loss);
  test.loss.planar_weight = 2;
  test.loss.planar_form = "triple_product";
  EXPECT_NEAR(
      Value(EvaluateStep(test, 0, [](RayOutputs*) {}), LossTerm::kPlanar),
      0,
      1e-6);
  const auto bent = [&] {
    return Value(EvaluateStep(test,
                              0,
                              [](RayOutputs* outputs) {
                                for (int ray = 3; ray < kMaxTileRays;
                                     ray += 4) {
                                  outputs->depth[ray] *= 1.1f;
                                }
                              }),
                 LossTerm::kPlanar);
  };
  const double loss = bent();
  EXPECT_GT(loss, 1e-4);
  test.loss.planar_weight = 4;
  EXPECT_NEAR(bent(), 2 * loss, 1e-4 * loss);
  test.loss.planar_form = "inverse_depth";
  EXPECT_GT(std::abs(bent() - 2 * loss), 0.1 * loss);
}

// As many rays as otherwise, but the patches are those around keypoints.
TEST(TrainingLoss, PatchesAtKeypointsOnly) {
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
TEST(TrainingLoss, SinglePixelsInsteadOfPatches) {
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

TEST(TrainingLoss, PriorByHand) {
  ObjectiveScene test;
  OnlyColor(&test.loss);
  test.loss.prior_weight = 0.5;
  test.MakeFrontal();
  const LossValues losses = EvaluateStep(
      test, 0, [](RayOutputs* outputs) { ScaleDepth(0.9f, outputs); });
  EXPECT_NEAR(Value(losses, LossTerm::kPrior), 0.5 * 0.01, 1e-6);
}

TEST(TrainingLoss, DensePriorPullsAtItsViewsRays) {
  ObjectiveScene test;
  OnlyColor(&test.loss);
  test.loss.dense_prior_weight = 0.5;
  test.AddPrior(1.1f);
  const TrainingObjective objective = test.MakeObjective();
  const auto tile_objective = objective.MakeTileObjective();
  double sum = 0;
  int num_pulled = 0;
  for (int tile = 0; tile < objective.NumTiles(); ++tile) {
    RayTile rays;
    tile_objective->DrawRays(0, tile, &rays);
    EXPECT_FALSE(rays.is_guided);
    RayOutputs outputs = test.TrueOutputs(rays);
    for (int ray = 0; ray < rays.num_rays; ++ray) {
      outputs.depth_variance[ray] = 1e-3f;
    }
    RayGradients gradients;
    sum += Value(tile_objective->Evaluate(outputs, &gradients),
                 LossTerm::kDensePrior);
    for (int ray = 0; ray < rays.num_rays; ++ray) {
      const bool has_prior = test.Identify(rays, ray).view_idx == 1;
      EXPECT_EQ(gradients.d_depth[ray] < 0, has_prior);
      num_pulled += has_prior;
    }
  }
  EXPECT_GT(num_pulled, 10);
  EXPECT_NE(sum, 0);
}

TEST(TrainingLoss, SparseEndsAndPriorFades) {
  ObjectiveScene test;
  test.MakeFrontal();
  test.loss.sparse_fraction = 0.5;
  test.loss.prior_fraction = 0.4;
  std::vector<LossValues> losses;
  for (int step = 0; step < 100; ++step) {
    losses.push_back(EvaluateStep(
        test, step, [](RayOutputs* outputs) { ScaleDepth(1.2f, outputs); }));
  }
  for (int step = 0; step < 100; ++step) {
    if (step < 50) {
      EXPECT_GT(Value(losses[step], LossTerm::kSparse), 1e-3) << step;
    } else {
      EXPECT_EQ(Value(losses[step], LossTerm::kSparse), 0) << step;
    }
    if (step < 40) {
      EXPECT_NEAR(Value(losses[step], LossTerm::kPrior),
                  Value(losses[0], LossTerm::kPrior) * (1 - step / 40.0),
                  1e-4 * Value(losses[0], LossTerm::kPrior))
          << step;
      EXPECT_GT(Value(losses[step], LossTerm::kPrior), 0) << step;
    } else {
      EXPECT_EQ(Value(losses[step], LossTerm::kPrior), 0) << step;
    }
    EXPECT_GT(Value(losses[step], LossTerm::kPatch), 0) << step;
    EXPECT_GT(Value(losses[step], LossTerm::kPlanar), -1e-9) << step;
  }
}

TEST(TrainingLoss, FractionsOfZeroAndOne) {
  ObjectiveScene test;
  test.loss.sparse_fraction = 0;
  test.loss.prior_fraction = 0;
  const auto evaluate = [&](const int step) {
    return EvaluateStep(
        test, step, [](RayOutputs* outputs) { ScaleDepth(1.2f, outputs); });
  };
  EXPECT_EQ(Value(evaluate(0), LossTerm::kSparse), 0);
  EXPECT_EQ(Value(evaluate(0), LossTerm::kPrior), 0);
  test.loss.sparse_fraction = 1;
  test.loss.prior_fraction = 1;
  EXPECT_GT(Value(evaluate(99), LossTerm::kSparse), 0);
  EXPECT_GT(Value(evaluate(99), LossTerm::kPrior), 0);
}

// A point of three times the error of another counts exp(-2) of it.
TEST(TrainingLoss, PointsWeighByTheirError) {
  ObjectiveScene test;
  OnlyColor(&test.loss);
  test.loss.sparse_weight = 1;
  test.scene.points.clear();
  test.AddPoint(0.1, 0.1, 0.5);
  test.AddPoint(-0.1, -0.05, 1.5);
  const TrainingObjective objective = test.MakeObjective();
  const auto tile_objective = objective.MakeTileObjective();
  double smallest = 1e9;
  double largest = 0;
  for (int tile = 0; tile < objective.NumTiles(); ++tile) {
    RayTile rays;
    tile_objective->DrawRays(0, tile, &rays);
    RayGradients gradients;
    tile_objective->Evaluate(test.TrueOutputs(rays), &gradients);
    for (int ray = 0; ray < rays.num_rays; ++ray) {
      if (gradients.pull[ray] > 0) {
        smallest = std::min<double>(smallest, gradients.pull[ray]);
        largest = std::max<double>(largest, gradients.pull[ray]);
        EXPECT_NEAR(gradients.pull_z[ray],
                    test.TrueDepth(test.Identify(rays, ray)),
                    1e-5);
      }
    }
  }
  EXPECT_NEAR(smallest / largest, std::exp(-2.25) / std::exp(-0.25), 1e-5);
}

// The same scene in millimetres and kilometres.
TEST(TrainingLoss, DoesNotDependOnTheScaleOfTheWorld) {
  const auto evaluate = [](const double scale) {
    ObjectiveScene test;
    test.plane.point *= scale;
    for (View& view : test.scene.views) {
      view.cam_from_world_translation *= scale;
    }
    for (SparsePoint& point : test.scene.points) {
      point.xyz *= scale;
    }
    test.frame = ComputeSceneFrame(test.scene);
    return EvaluateStep(
        test, 0, [](RayOutputs* outputs) { ScaleDepth(1.15f, outputs); });
  };
  const LossValues expected = evaluate(1);
  for (const double scale : {1e-3, 1e3}) {
    const LossValues losses = evaluate(scale);
    for (size_t term = 0; term < losses.size(); ++term) {
      EXPECT_NEAR(losses[term], expected[term], 1e-4 * expected[term] + 1e-7)
          << "term " << term;
    }
  }
}

// The derivatives belong to the value that is reported, in every output of
// every ray, all terms at once.
void CheckReportedGradients(const std::string& sparse_form,
                            const std::string& planar_form) {
  ObjectiveScene test;
  test.loss.sparse_form = sparse_form;
  test.loss.planar_form = planar_form;
  test.loss.color_weight = 0.7;
  test.loss.patch_weight = 1.3;
  test.loss.planar_weight = 0.6;
  test.loss.sparse_weight = 0.9;
  test.loss.prior_weight = 0.4;
  const TrainingObjective objective = test.MakeObjective();
  const auto tile_objective = objective.MakeTileObjective();
  Random random(5);
  int num_depths = 0;
  int num_kinks = 0;
  for (int tile = 0; tile < objective.NumTiles(); ++tile) {
    RayTile rays;
    tile_objective->DrawRays(10, tile, &rays);
    RayOutputs outputs = test.TrueOutputs(rays);
    for (int ray = 0; ray < rays.num_rays; ++ray) {
      outputs.depth[ray] *= 0.9f + 0.2f * random.NextFloat();
      outputs.depth_variance[ray] = 1e-3f * random.NextFloat();
      for (PerRay<float>& channel : outputs.color) {
        channel[ray] += random.NextFloat() - 0.5f;
      }
    }
    RayGradients gradients;
    tile_objective->Evaluate(outputs, &gradients);
    const auto evaluate = [&](float* const value, const double at) {
      const float center = *value;
      *value = static_cast<float>(at);
      RayGradients ignored;
      const double loss = Sum(tile_objective->Evaluate(outputs, &ignored));
      *value = center;
      return loss;
    };
    // One-sided differences, to notice the kinks of the patch loss.
    const auto differentiate =
        [&](float* const value, const float h, double* left, double* right) {
          const double center = evaluate(value, *value);
          const float above = *value + h;
          const float below = *value - h;
          *right = (evaluate(value, above) - center) /
                   (static_cast<double>(above) - *value);
          *left = (center - evaluate(value, below)) /
                  (static_cast<double>(*value) - below);
        };
    for (int ray = 0; ray < rays.num_rays; ++ray) {
      double left;
      double right;
      for (int c = 0; c < 3; ++c) {
        differentiate(&outputs.color[c][ray], 1e-3f, &left, &right);
        EXPECT_NEAR(gradients.d_color[c][ray], 0.5 * (left + right), 1e-6);
      }
      const double z = gradients.pull_z[ray];
      const double pull =
          gradients.pull[ray] != 0 ? gradients.pull[ray] / (z * z) : 0.0;
      differentiate(&outputs.depth_variance[ray], 1e-4f, &left, &right);
      EXPECT_NEAR(pull, 0.5 * (left + right), 1e-3 * pull + 1e-6);

      differentiate(&outputs.depth[ray], 1e-4f, &left, &right);
      const double expected =
          gradients.d_depth[ray] + 2 * pull * (outputs.depth[ray] - z);
      const double scale = 1e-3 + std::abs(left) + std::abs(right);
      ++num_depths;
      if (std::abs(right - left) > 0.05 * scale) {
        ++num_kinks;
        continue;
      }
      EXPECT_NEAR(0.5 * (left + right), expected, 0.03 * scale)
          << "ray " << ray << " of tile " << tile;
    }
  }
  EXPECT_LT(num_kinks, 0.1 * num_depths);
}

TEST(TrainingLoss, GradientsAreThoseOfTheReportedValue) {
  CheckReportedGradients("line_of_sight", "inverse_depth");
}

TEST(TrainingLoss, GradientsOfTheOtherForms) {
  CheckReportedGradients("squared", "triple_product");
}

// Down the whole chain: sampling, networks, rendering, losses. The derivative
// of the reported loss along the gradient is the gradient's length.
void CheckDescent(const std::string& sparse_form,
                  const std::string& planar_form) {
  ObjectiveScene test;
  test.loss.sparse_form = sparse_form;
  test.loss.planar_form = planar_form;
  // Without the patch loss, whose kinks a step of this size meets.
  test.loss.patch_weight = 0;
  const TrainingObjective objective = test.MakeObjective();
  EngineOptions options;
  options.field.num_levels = 2;
  options.field.log2_table_size = 10;
  options.field.max_resolution = 32;
  options.extent = test.frame.extent;
  options.num_threads = 1;
  // Each evaluation has its own engine: accumulating teaches the density cache.
  const auto accumulate = [&](const FieldParameters& parameters,
                              FieldParameters* gradients) {
    const auto engine = MakeFusedEngine(options);
    engine->SetParameters(parameters);
    std::vector<std::unique_ptr<TileObjective>> objectives;
    objectives.push_back(objective.MakeTileObjective());
    StepParameters step;
    step.step = 5;
    step.num_tiles = objective.NumTiles();
    const LossValues losses = engine->Accumulate(step, objectives);
    *gradients = engine->Gradients();
    return Sum(losses);
  };
  const FieldLayout layout(options.field, options.extent);
  const FieldParameters parameters = RandomParameters(layout, 1.0f, 4.0f, 3);
  FieldParameters gradients;
  accumulate(parameters, &gradients);
  double squared_norm = 0;
  for (const float g : gradients.network) {
    squared_norm += static_cast<double>(g) * g;
  }
  const double norm = std::sqrt(squared_norm);
  ASSERT_GT(norm, 1e-3);
  const auto moved = [&](const double distance) {
    FieldParameters result = parameters;
    for (size_t i = 0; i < result.network.size(); ++i) {
      result.network[i] +=
          static_cast<float>(distance * gradients.network[i] / norm);
    }
    FieldParameters ignored;
    return accumulate(result, &ignored);
  };
  const double h = 2e-3;
  EXPECT_NEAR((moved(h) - moved(-h)) / (2 * h), norm, 0.01 * norm);
}

TEST(TrainingLoss, EngineDescendsWhatIsReported) {
  CheckDescent("line_of_sight", "inverse_depth");
}

TEST(TrainingLoss, EngineDescendsTheOtherForms) {
  CheckDescent("squared", "triple_product");
  CheckDescent("kl", "inverse_depth");
}

}  // namespace
}  // namespace structnerf
