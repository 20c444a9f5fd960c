// What training adds up over the rays of a tile, in float against its formulas
// in double.

#include "nerf/util/random.h"
#include "tests/nerf/train/objective_scene.h"
#include "tests/stability/loss_error.h"
#include "tests/stability/stability_case.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

namespace structnerf {
namespace {

constexpr int kNumTiles = 8;

// Index of the pixel that a ray goes through.
size_t PixelOf(const ObjectiveScene& scene,
               const ObjectiveScene::ImagePoint& point) {
  return static_cast<size_t>(point.Row()) *
             scene.scene.views[point.view_idx].image.width +
         point.Col();
}

// Random colours at about a depth.
RayOutputs RandomOutputs(const RayTile& rays,
                         const double depth,
                         Random* random) {
  RayOutputs outputs = {};
  for (int ray = 0; ray < rays.num_rays; ++ray) {
    outputs.depth[ray] =
        static_cast<float>(depth * (0.5 + random->NextFloat()));
    outputs.depth_variance[ray] = static_cast<float>(depth * depth);
    for (int c = 0; c < 3; ++c) {
      outputs.color[c][ray] = random->NextFloat();
    }
  }
  return outputs;
}

// The colour loss of a tile.
double ColorLossInDouble(const ObjectiveScene& scene,
                         const RayTile& rays,
                         const RayOutputs& outputs,
                         const RayGradients& gradients,
                         LossError* error) {
  const double weight = scene.loss.color_weight / scene.training.rays_per_step;
  double loss = 0;
  for (int ray = 0; ray < rays.num_rays; ++ray) {
    const ObjectiveScene::ImagePoint point = scene.Identify(rays, ray);
    const View& view = scene.scene.views[point.view_idx];
    for (int c = 0; c < 3; ++c) {
      const double gain = view.exposure.gain[c];
      const double shown =
          gain * outputs.color[c][ray] + view.exposure.offset[c];
      const double target =
          view.image.data[3 * PixelOf(scene, point) + c] / 255.0;
      const double slope = 2 * gain * (shown - target);
      loss += weight * std::pow(shown - target, 2);
      error->gradient =
          std::max(error->gradient,
                   std::abs(gradients.d_color[c][ray] / weight - slope) /
                       (1 + gain * (std::abs(shown) + target)));
    }
  }
  return loss;
}

std::string MeasureColorLossAndHints() {
  ObjectiveScene scene;
  const TrainingObjective objective = scene.MakeObjective();
  const auto tile = objective.MakeTileObjective();
  Random random(3);
  LossError error;
  for (double depth = 1e-8; depth < 1e8; depth *= 10) {
    for (int i = 0; i < kNumTiles; ++i) {
      RayTile rays;
      tile->DrawRays(0, i, &rays);
      const RayOutputs outputs = RandomOutputs(rays, depth, &random);
      RayGradients gradients;
      const LossValues losses = tile->Evaluate(outputs, &gradients);
      const double color =
          ColorLossInDouble(scene, rays, outputs, gradients, &error);
      double hints = 0;
      for (int ray = 0; ray < rays.num_rays; ++ray) {
        if (gradients.pull[ray] > 0) {
          const double z = gradients.pull_z[ray];
          hints +=
              gradients.pull[ray] * (std::pow((outputs.depth[ray] - z) / z, 2) +
                                     outputs.depth_variance[ray] / (z * z));
        }
      }
      const auto compare = [&](const double loss, const double expected) {
        error.value = std::max(error.value, std::abs(loss / expected - 1));
      };
      compare(losses[static_cast<size_t>(LossTerm::kColor)], color);
      compare(losses[static_cast<size_t>(LossTerm::kSparse)] +
                  losses[static_cast<size_t>(LossTerm::kPrior)],
              hints);
    }
  }
  return Accept(error, 1e-5, 1e-5);
}

// Photographs far darker and brighter than the scene.
std::string MeasureExposedColor() {
  Random random(4);
  LossError error;
  for (double gain = 1e-6; gain < 1e7; gain *= 10) {
    for (const float offset : {-1.0f, 0.0f, 1.0f}) {
      ObjectiveScene scene;
      for (View& view : scene.scene.views) {
        for (int c = 0; c < 3; ++c) {
          view.exposure.gain[c] =
              static_cast<float>(gain * (1 + random.NextFloat()));
          view.exposure.offset[c] = offset * random.NextFloat();
        }
      }
      const TrainingObjective objective = scene.MakeObjective();
      const auto tile = objective.MakeTileObjective();
      for (int i = 0; i < kNumTiles; ++i) {
        RayTile rays;
        tile->DrawRays(0, i, &rays);
        const RayOutputs outputs = RandomOutputs(rays, 0.3, &random);
        RayGradients gradients;
        const double loss = tile->Evaluate(
            outputs, &gradients)[static_cast<size_t>(LossTerm::kColor)];
        const double expected =
            ColorLossInDouble(scene, rays, outputs, gradients, &error);
        error.value = std::max(error.value, std::abs(loss / expected - 1));
      }
    }
  }
  return Accept(error, 1e-5, 1e-5);
}

// Priors beside what is rendered, sharp and blurred.
std::string MeasureDensePrior() {
  ObjectiveScene scene;
  const auto median_depth = static_cast<float>(scene.frame.median_depth);
  const float field_scale = static_cast<float>(scene.frame.scale);
  scene.loss = LossOptions();
  scene.loss.patch_weight = 0;
  scene.loss.planar_weight = 0;
  scene.loss.sparse_weight = 0;
  scene.loss.prior_weight = 0;
  scene.loss.far_weight = 0;
  scene.loss.dense_prior_weight = 1;
  const double weight =
      scene.loss.dense_prior_weight / scene.training.rays_per_step;
  Random random(5);
  LossError error;
  for (double depth = 1e-8; depth < 1e3; depth *= 10) {
    for (View& view : scene.scene.views) {
      view.prior_depth.clear();
      for (size_t i = 0; i < view.image.data.size() / 3; ++i) {
        view.prior_depth.push_back(static_cast<float>(
            depth * (2 + random.NextFloat()) / scene.frame.scale));
      }
      view.prior_deviation.assign(view.prior_depth.size(), 1e-12f);
    }
    const TrainingObjective objective = scene.MakeObjective();
    const auto tile = objective.MakeTileObjective();
    for (const double deviation : {0.0, 1e-3, 1.0}) {
      for (int i = 0; i < kNumTiles; ++i) {
        RayTile rays;
        tile->DrawRays(0, i, &rays);
        RayOutputs outputs = RandomOutputs(rays, depth, &random);
        outputs.depth_variance.fill(
            static_cast<float>(std::pow(deviation * depth, 2)));
        RayGradients gradients;
        const double loss = tile->Evaluate(
            outputs, &gradients)[static_cast<size_t>(LossTerm::kDensePrior)];
        double expected = 0;
        double magnitude = 0;
        for (int ray = 0; ray < rays.num_rays; ++ray) {
          const ObjectiveScene::ImagePoint point = scene.Identify(rays, ray);
          const float prior = scene.scene.views[point.view_idx]
                                  .prior_depth[PixelOf(scene, point)] *
                              field_scale;
          const double offset =
              (double{outputs.depth[ray]} - prior) / median_depth;
          const double variance =
              outputs.depth_variance[ray] / std::pow(median_depth, 2) + 1e-6;
          expected +=
              weight * (std::log(variance) + offset * offset / variance);
          magnitude += weight * (std::abs(std::log(variance)) +
                                 offset * offset / variance);
          error.gradient =
              std::max(error.gradient,
                       RelativeError(gradients.d_depth[ray] / weight,
                                     2 * offset / variance / median_depth));
        }
        error.value =
            std::max(error.value, std::abs(loss - expected) / magnitude);
      }
    }
  }
  return Accept(error, 1e-5, 1e-5);
}

}  // namespace

std::vector<StabilityCase> ObjectiveCases() {
  return {
      {"colour, sparse and prior loss: depths of 1e-8 to 1e8",
       MeasureColorLossAndHints},
      {"colour loss with exposures: gains of 1e-6 to 1e7", MeasureExposedColor},
      {"dense prior loss: depths of 1e-8 to 1e3", MeasureDensePrior}};
}

}  // namespace structnerf
