#include "tests/nerf/engine/random_scene.h"

#include "nerf/kernels/half_precision.h"

#include <cmath>

namespace structnerf {
namespace {

float Uniform(const float low, const float high, Random* random) {
  return low + (high - low) * random->NextFloat();
}

}  // namespace

RayTile RandomRays(const uint64_t seed,
                   const int step,
                   const int tile,
                   const int num_rays) {
  Random random(seed, step, tile);
  RayTile rays;
  rays.num_rays = num_rays;
  for (int ray = 0; ray < num_rays; ++ray) {
    float squared_norm = 0;
    for (int axis = 0; axis < 3; ++axis) {
      rays.origin[axis][ray] = Uniform(0.05f, 0.95f, &random);
      const float direction = Uniform(-1, 1, &random);
      rays.direction[axis][ray] = direction;
      squared_norm += direction * direction;
    }
    // Length one along some axis, as camera rays along the camera's.
    const float norm = Uniform(1, 1.5f, &random);
    for (int axis = 0; axis < 3; ++axis) {
      rays.direction[axis][ray] *= norm / std::sqrt(squared_norm);
    }
    rays.direction_norm[ray] = norm;
    rays.near[ray] = Uniform(0.02f, 0.1f, &random);
    rays.far[ray] = rays.near[ray] + Uniform(0.3f, 1.5f, &random);
  }
  return rays;
}

RandomObjective::RandomObjective(const uint64_t seed, const int rays_per_tile)
    : seed_(seed), rays_per_tile_(rays_per_tile) {}

void RandomObjective::DrawRays(const int step, const int tile, RayTile* rays) {
  step_ = step;
  tile_ = tile;
  int num_rays = rays_per_tile_;
  if (tile % 7 == 6) {
    num_rays = 0;
  } else if (tile % 7 == 5) {
    num_rays = (rays_per_tile_ + 2) / 3;
  }
  rays_ = RandomRays(seed_, step, tile, num_rays);
  *rays = rays_;
  Random random(seed_ + 1, step, tile);
  gradients_ = RayGradients();
  for (int ray = 0; ray < num_rays; ++ray) {
    for (PerRay<float>& channel : gradients_.d_color) {
      channel[ray] = Uniform(-1, 1, &random);
    }
    gradients_.d_depth[ray] = Uniform(-1, 1, &random);
    gradients_.d_opacity[ray] = Uniform(-1, 1, &random);
    if (ray % 2 == 1) {
      gradients_.pull[ray] = Uniform(0, 1, &random);
      gradients_.pull_z[ray] =
          Uniform(rays_.near[ray], rays_.far[ray], &random);
    }
  }
}

LossValues RandomObjective::Evaluate(const RayOutputs& outputs,
                                     RayGradients* gradients) {
  *gradients = gradients_;
  LossValues losses = {};
  for (int ray = 0; ray < rays_.num_rays; ++ray) {
    for (int c = 0; c < 3; ++c) {
      losses[0] += gradients_.d_color[c][ray] * outputs.color[c][ray];
    }
    losses[1] += gradients_.d_depth[ray] * outputs.depth[ray];
    losses[2] += gradients_.d_opacity[ray] * outputs.opacity[ray];
    if (gradients_.pull[ray] != 0) {
      const float target = gradients_.pull_z[ray];
      const float offset = outputs.depth[ray] - target;
      losses[3] += gradients_.pull[ray] *
                   (outputs.depth_variance[ray] + offset * offset) /
                   (target * target);
    }
  }
  return losses;
}

LossValues RandomObjective::EvaluateSamples(const RaySamples& samples,
                                            float* d_weight) {
  Random random(seed_ + 2, step_, tile_);
  LossValues losses = {};
  for (int i = 0; i < rays_.num_rays * samples.num_samples; ++i) {
    const float derivative = Uniform(-1, 1, &random);
    d_weight[i] += derivative;
    losses[4] += derivative * samples.weight[i];
  }
  return losses;
}

std::vector<std::unique_ptr<TileObjective>> RandomObjectives(
    const RenderEngine& engine, const uint64_t seed, const int rays_per_tile) {
  std::vector<std::unique_ptr<TileObjective>> objectives;
  for (int i = 0; i < engine.NumThreads(); ++i) {
    objectives.push_back(
        std::make_unique<RandomObjective>(seed, rays_per_tile));
  }
  return objectives;
}

FieldParameters RandomParameters(const FieldLayout& layout,
                                 const float grid_range,
                                 const float initial_density,
                                 const uint64_t seed) {
  FieldParameters parameters = InitialParameters(layout, initial_density, seed);
  Random random(seed, 1);
  for (float& feature : parameters.grid) {
    feature = Uniform(-grid_range, grid_range, &random);
  }
  std::vector<hwy::float16_t> half(parameters.grid.size());
  HalfFromFloat(parameters.grid.data(), half.size(), half.data());
  FloatFromHalf(half.data(), half.size(), parameters.grid.data());
  for (const LayerLayout* layer : {&layout.density_hidden,
                                   &layout.density_output,
                                   &layout.color_hidden,
                                   &layout.color_output}) {
    for (int i = 0; i < layer->num_outputs; ++i) {
      parameters.network[layer->biases + i] += Uniform(-0.5f, 0.5f, &random);
    }
  }
  return parameters;
}

}  // namespace structnerf
