// Terms of the training objective that look at depth: sparse points, priors,
// planar superpixels, and the push of what is blank.

#include "nerf/train/training_objective.h"
#include "tests/nerf/train/objective_scene.h"
#include "tests/nerf/train/step_losses.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

namespace structnerf {
namespace {

TEST(DepthTerms, SparseByHand) {
  ObjectiveScene test;
  OnlyColor(&test.loss);
  test.loss.sparse_weight = 3;
  // All errors equal: each weighs exp(-1).
  for (SparsePoint& point : test.scene.points) {
    point.error = 0.7;
  }
  for (const int rays_per_step : {32, 33, 256}) {
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

TEST(DepthTerms, SquaredSparseByHand) {
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
TEST(DepthTerms, RayTerminationByHand) {
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

TEST(DepthTerms, OtherFormsUseNoSamples) {
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

// A point of three times the error of another counts exp(-2) of it.
TEST(DepthTerms, PointsWeighByTheirError) {
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

TEST(DepthTerms, PriorByHand) {
  ObjectiveScene test;
  OnlyColor(&test.loss);
  test.loss.prior_weight = 0.5;
  test.MakeFrontal();
  const LossValues losses = EvaluateStep(
      test, 0, [](RayOutputs* outputs) { ScaleDepth(0.9f, outputs); });
  EXPECT_NEAR(Value(losses, LossTerm::kPrior), 0.5 * 0.01, 1e-6);
}

TEST(DepthTerms, DensePriorPullsAtItsViewsRays) {
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

TEST(DepthTerms, MatchedDepthPullsAtItsPixelsRays) {
  ObjectiveScene test;
  OnlyColor(&test.loss);
  test.loss.match_weight = 0.5;
  TrainingObjective objective = test.MakeObjective();
  const auto tile_objective = objective.MakeTileObjective();
  // Of the second view, and of its left half only.
  auto matched = std::make_shared<MatchedDepth>(test.scene.views.size());
  for (size_t v = 0; v < matched->size(); ++v) {
    const TrainingViews::Image& image =
        objective.Views().image(static_cast<int>(v));
    for (int row = 0; row < image.height; ++row) {
      for (int col = 0; col < image.width; ++col) {
        (*matched)[v].push_back(v == 1 && 2 * col < image.width ? 100.0f : 0);
      }
    }
  }
  int num_pulled = 0;
  for (const bool is_known : {false, true}) {
    if (is_known) {
      objective.SetMatchedDepth(matched);
    }
    for (int tile = 0; tile < objective.NumTiles(); ++tile) {
      RayTile rays;
      tile_objective->DrawRays(0, tile, &rays);
      RayOutputs outputs = test.TrueOutputs(rays);
      for (int ray = 0; ray < rays.num_rays; ++ray) {
        outputs.depth_variance[ray] = 1e-3f;
      }
      RayGradients gradients;
      const double loss = Value(tile_objective->Evaluate(outputs, &gradients),
                                LossTerm::kMatchedDepth);
      int num_expected = 0;
      for (int ray = 0; ray < rays.num_rays; ++ray) {
        const auto place = test.Identify(rays, ray);
        const bool is_pulled =
            is_known && place.view_idx == 1 &&
            2 * std::floor(place.x) < objective.Views().image(1).width;
        // Farther away than it is.
        EXPECT_EQ(gradients.d_depth[ray] < 0, is_pulled);
        num_expected += is_pulled;
      }
      EXPECT_EQ(loss != 0, num_expected > 0);
      num_pulled += num_expected;
    }
  }
  EXPECT_GT(num_pulled, 10);
}

// Four corners of a unit step in depth: the triple product notices what leaves
// the plane, in units of the median depth, whatever the planar scale.
TEST(DepthTerms, TripleProductOfTheWallVanishes) {
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

TEST(DepthTerms, BlankPixelsArePushedAway) {
  ObjectiveScene test;
  OnlyColor(&test.loss);
  test.loss.far_weight = 0.5;
  test.training.rays_per_step = kMaxTileRays;
  for (View& view : test.scene.views) {
    std::fill(view.image.data.begin(), view.image.data.end(), uint8_t{128});
  }
  const TrainingObjective objective = test.MakeObjective();
  const auto tile_objective = objective.MakeTileObjective();
  RayTile rays;
  tile_objective->DrawRays(0, 0, &rays);
  const RayOutputs outputs = test.TrueOutputs(rays);
  RayGradients gradients;
  const LossValues losses = tile_objective->Evaluate(outputs, &gradients);
  double expected = 0;
  for (int ray = 0; ray < rays.num_rays; ++ray) {
    expected -= 0.5 / kMaxTileRays * std::log(outputs.depth[ray]);
    EXPECT_NEAR(
        gradients.d_depth[ray], -0.5 / kMaxTileRays / outputs.depth[ray], 1e-6);
  }
  EXPECT_NEAR(Value(losses, LossTerm::kFar), expected, 1e-5);
}

}  // namespace
}  // namespace structnerf
