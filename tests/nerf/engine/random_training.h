#pragma once

#include "nerf/engine/grid_engine.h"
#include "tests/nerf/engine/random_scene.h"

#include <vector>

namespace structnerf {

// Small engines that are trained on random gradients, to be compared.

constexpr int kTileRays = 11;

EngineOptions MakeOptions(int num_threads);

// Of 13 tiles.
StepParameters MakeStep(int step);

// Takes some steps, and refreshes the density cache after every third. Returns
// the losses.
std::vector<double> Train(int first_step, int num_steps, RenderEngine* engine);

// Expects that two engines render the same rays of the same field alike.
void ExpectSameRendering(const std::vector<RayTile>& tiles,
                         GridEngine* engine,
                         GridEngine* other);

}  // namespace structnerf
