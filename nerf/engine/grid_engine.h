#pragma once

#include "nerf/engine/render_engine.h"
#include "nerf/field/density_cache.h"
#include "nerf/field/field_layout.h"
#include "nerf/kernels/ray_sampling.h"

#include <memory>
#include <vector>

namespace structnerf {

// What engines of the hash grid have in common. They sample where a density
// cache says that light may end.
class GridEngine : public RenderEngine {
 public:
  virtual const FieldLayout& Layout() const = 0;
  virtual const DensityCache& Cache() const = 0;

  size_t NumParameters() const override { return Layout().NumParameters(); }
  void RebuildDensityCache(Progress* progress) override;

 protected:
  virtual DensityCache* MutableCache() = 0;

  // A cache that has seen nothing yet.
  static DensityCache MakeCache(const EngineOptions& options);

  static RaySamplingParameters MakeSamplingParameters(
      const SamplingOptions& options);

  // The learning rate of parameters that are updated in every step, with
  // Adam's correction of the bias of its moments (Kingma and Ba 2015, section
  // 2) after that many updates.
  static float BiasCorrectedRate(float learning_rate, int num_updates);

  // Multiplies features by the weight of their level; empty = all one.
  static void ApplyLevelWeights(const FieldLayout& layout,
                                const std::vector<float>& level_weights,
                                std::vector<float>* grid);

  // The part of a state that all implementations have. Reading throws
  // std::runtime_error if it is not that of `layout`.
  static void SaveHead(const FieldLayout& layout,
                       const std::vector<float>& level_weights,
                       int num_updates,
                       StateWriter* writer);
  static void LoadHead(const FieldLayout& layout,
                       StateReader* reader,
                       std::vector<float>* level_weights,
                       int* num_updates);
};

// Hand-vectorised for the CPU, tiles of rays over threads. Its results do not
// depend on the number of threads.
std::unique_ptr<GridEngine> MakeFusedEngine(const EngineOptions& options);

}  // namespace structnerf
