// Derivatives of the training objective, all terms at once.

#include "nerf/engine/grid_engine.h"
#include "nerf/train/training_objective.h"
#include "nerf/util/random.h"
#include "tests/nerf/engine/random_scene.h"
#include "tests/nerf/train/objective_scene.h"
#include "tests/nerf/train/step_losses.h"

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace structnerf {
namespace {

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

TEST(TrainingGradients, GradientsAreThoseOfTheReportedValue) {
  CheckReportedGradients("line_of_sight", "inverse_depth");
}

TEST(TrainingGradients, GradientsOfTheOtherForms) {
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

TEST(TrainingGradients, EngineDescendsWhatIsReported) {
  CheckDescent("line_of_sight", "inverse_depth");
}

TEST(TrainingGradients, EngineDescendsTheOtherForms) {
  CheckDescent("squared", "triple_product");
  CheckDescent("kl", "inverse_depth");
}

}  // namespace
}  // namespace structnerf
