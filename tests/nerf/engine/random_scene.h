#pragma once

#include "nerf/engine/render_engine.h"
#include "nerf/util/random.h"

#include <memory>
#include <vector>

namespace structnerf {

// Rays from anywhere in the unit box in any direction, long enough to leave it,
// that depend on the numbers only.
RayTile RandomRays(uint64_t seed, int step, int tile, int num_rays);

// An objective with derivatives that do not depend on what is rendered, so that
// two engines get the very same ones: L = sum (d_color color + d_depth depth +
// d_opacity opacity) + line-of-sight term on every second ray. The last tile
// has fewer rays and every seventh is empty.
class RandomObjective : public TileObjective {
 public:
  RandomObjective(uint64_t seed, int rays_per_tile);

  void DrawRays(int step, int tile, RayTile* rays) override;
  LossValues Evaluate(const RayOutputs& outputs,
                      RayGradients* gradients) override;

  // Adds sum d_weight weight over the samples of every third tile.
  bool UsesSamples() const override { return tile_ % 3 == 1; }
  LossValues EvaluateSamples(const RaySamples& samples,
                             float* d_weight) override;

 private:
  uint64_t seed_;
  int rays_per_tile_;
  int step_ = 0;
  int tile_ = 0;
  RayTile rays_;
  RayGradients gradients_;
};

std::vector<std::unique_ptr<TileObjective>> RandomObjectives(
    const RenderEngine& engine, uint64_t seed, int rays_per_tile);

// Parameters of a field with structure: grid features in +-grid_range, rounded
// to half precision, networks as initialised with random biases.
FieldParameters RandomParameters(const FieldLayout& layout,
                                 float grid_range,
                                 float initial_density,
                                 uint64_t seed);

}  // namespace structnerf
