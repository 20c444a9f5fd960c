#pragma once

#include "nerf/train/training_objective.h"
#include "tests/nerf/train/objective_scene.h"

#include <cstddef>
#include <functional>
#include <numeric>

namespace structnerf {

// Of one term.
inline double Value(const LossValues& losses, const LossTerm term) {
  return losses[static_cast<size_t>(term)];
}

// Of all terms.
inline double Sum(const LossValues& losses) {
  return std::accumulate(losses.begin(), losses.end(), 0.0);
}

// Every term off but the colour.
inline void OnlyColor(LossOptions* options) {
  options->patch_weight = 0;
  options->planar_weight = 0;
  options->sparse_weight = 0;
  options->prior_weight = 0;
  options->far_weight = 0;
}

// Losses of one step, with outputs that differ from the truth by what `change`
// makes of them.
inline LossValues EvaluateStep(const ObjectiveScene& test,
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

// Of all rays of a tile.
inline void ScaleDepth(const float factor, RayOutputs* outputs) {
  for (float& depth : outputs->depth) {
    depth *= factor;
  }
}

}  // namespace structnerf
