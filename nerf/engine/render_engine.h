#pragma once

#include "nerf/engine/ray_tile.h"
#include "nerf/field/field_layout.h"
#include "nerf/options.h"
#include "nerf/progress.h"
#include "nerf/util/state_stream.h"

#include <array>
#include <cstddef>
#include <memory>
#include <vector>

#include <Eigen/Core>

namespace structnerf {

// Terms of the objective, for bookkeeping.
enum class LossTerm {
  kColor,
  kPatch,
  kPlanar,
  kSparse,
  kPrior,
  kDensePrior,
  kMatchedDepth,
  kFar,
  kCount
};
using LossValues = std::array<double, static_cast<size_t>(LossTerm::kCount)>;
void AddLosses(const LossValues& losses, LossValues* sum);

// What is minimised, seen from one thread: draws the rays of a tile and, once
// they are rendered, gives the loss and its derivatives. What it draws depends
// on step and tile only.
class TileObjective {
 public:
  virtual ~TileObjective() = default;

  virtual void DrawRays(int step, int tile, RayTile* rays) = 0;

  // For the rays drawn last. Adds to `gradients`, which start at zero, and
  // returns the weighted loss values that belong to them.
  virtual LossValues Evaluate(const RayOutputs& outputs,
                              RayGradients* gradients) = 0;

  // Whether a term needs the samples of the rays drawn last.
  virtual bool UsesSamples() const { return false; }

  // Called after Evaluate() if so. Adds derivatives by the samples' weights to
  // `d_weight` (rays x n, zero at first) and returns the loss values that
  // belong to them. Weights of a ray sum to one whatever the field, so a
  // constant per ray makes no difference.
  virtual LossValues EvaluateSamples(const RaySamples& /*samples*/,
                                     float* /*d_weight*/) {
    return {};
  }
};

// Parts of a training step, for profiles.
enum class EngineStage {
  kRays,            // drawing and sampling them
  kEncode,          // grid to features
  kDensityNetwork,  // forward
  kComposite,       // forward and backward
  kColorNetwork,    // forward
  kLosses,          // the objective
  kBackward,        // networks
  kSortGradient,    // of the grid, by tile
  kSumGradient,     // of the grid, by table region
  kUpdateGrid,      // Adam
  kUpdateNetwork,   // Adam
  kObserveDensity,  // density cache
  kCount
};
using StageSeconds =
    std::array<double, static_cast<size_t>(EngineStage::kCount)>;

// Work done in training steps.
struct WorkCounts {
  size_t num_rays = 0;
  size_t num_samples = 0;           // at which the density was evaluated
  size_t num_color_samples = 0;     // and the colour
  size_t num_gradient_samples = 0;  // whose gradient reached the grid
};

// What changes from step to step.
struct StepParameters {
  int step = 0;
  int num_tiles = 0;

  // Factor on each level's features, in [0, 1]: coarse to fine.
  std::vector<float> level_weights;
};

// The differentiable render op: a radiance field, the rendering of rays through
// it, gradients, and the update of its parameters. Implementations give the
// same results up to rounding; the trainer does not know which one runs.
class RenderEngine {
 public:
  virtual ~RenderEngine() = default;

  virtual size_t NumParameters() const = 0;

  // Renders the rays of step.num_tiles tiles, lets `objectives` (one per
  // thread, see NumThreads) judge them, and accumulates the gradient of the sum
  // of the losses. Returns that sum by term.
  virtual LossValues Accumulate(
      const StepParameters& step,
      const std::vector<std::unique_ptr<TileObjective>>& objectives) = 0;

  // Takes one step of Adam with the accumulated gradient and clears it. Returns
  // false if it was not finite; those parameters then stay as they were.
  virtual bool Update(float grid_learning_rate,
                      float network_learning_rate) = 0;

  // Evaluates the density of a part of the scene box for the density cache.
  // Engines that sample without one have nothing to do.
  virtual void RefreshDensityCache(float /*decay*/) {}

  // Evaluates the density of every cell anew, at several points each. For
  // rendering: training sees most of a cell's history, a rendered ray only what
  // the cache says now, and misses a surface where it says nothing. The result
  // depends on the parameters alone. Throws Aborted if told to abort.
  virtual void RebuildDensityCache(Progress* /*progress*/) {}

  // Renders tiles without gradients. Colour is left alone unless asked for.
  virtual void Render(const std::vector<RayTile>& tiles,
                      bool with_color,
                      std::vector<RayOutputs>* outputs) = 0;

  // The field as it is rendered: features times the weight their level last
  // had. Once set, all levels count fully.
  virtual FieldParameters Parameters() const = 0;
  virtual void SetParameters(const FieldParameters& parameters) = 0;

  // The parameters as they are trained, whatever weight their level has, and
  // going back to them: the optimiser's moments and the density cache then
  // start anew.
  virtual FieldParameters MasterParameters() const = 0;
  virtual void Restore(const FieldParameters& parameters) = 0;

  // Starts over as a new engine with this seed for the parameters would.
  virtual void Restart(int seed) = 0;

  // Everything that later steps depend on, unrounded: parameters, moments,
  // density cache, counts. To be called between Update() and Accumulate(). An
  // engine of the same options that loads it goes on to the very same numbers
  // on any number of threads (up to rounding on a graphics card). LoadState
  // throws std::runtime_error if the state is that of another layout.
  virtual void SaveState(StateWriter* writer) const = 0;
  virtual void LoadState(StateReader* reader) = 0;

  // The gradient accumulated so far.
  virtual FieldParameters Gradients() const = 0;

  // Number of objectives that Accumulate wants.
  virtual int NumThreads() const = 0;

  // Time spent in each stage so far, added up over threads; zero if the engine
  // does not keep it.
  virtual StageSeconds Profile() const { return {}; }

  // Work of all calls of Accumulate so far; zero if the engine does not count.
  virtual WorkCounts Work() const { return {}; }
};

// What every implementation is built from.
struct EngineOptions {
  FieldOptions field;
  SamplingOptions sampling;
  Eigen::Vector3f extent = Eigen::Vector3f::Ones();  // of the scene box

  // Density at the start, per field unit.
  float initial_density = 1.0f;

  // Samples of less weight have no colour of their own: the ray's is the mean
  // of the others. Less than one over the number of samples.
  float min_color_weight = 1e-4f;

  // Photographs that have a latent code, for fields with such codes.
  int num_views = 0;

  int num_threads = -1;
  int seed = 0;
};

}  // namespace structnerf
