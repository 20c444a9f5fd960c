#pragma once

#include "nerf/engine/fused_grid.h"
#include "nerf/engine/fused_network.h"
#include "nerf/engine/ray_tile.h"
#include "nerf/engine/render_engine.h"
#include "nerf/engine/stage_clock.h"
#include "nerf/field/density_cache.h"
#include "nerf/kernels/compositing.h"
#include "nerf/kernels/ray_sampling.h"
#include "nerf/util/aligned_buffer.h"
#include "nerf/util/random.h"

#include <cstddef>
#include <vector>

namespace structnerf {

// What is rendered.
struct FusedField {
  const FusedGrid& grid;
  const FusedNetwork& network;
  const DensityCache& cache;
  const std::vector<float>& level_weights;
};

// Renders tiles of rays, forward and backward, on one thread. All its memory is
// allocated at the start.
class FusedTile {
 public:
  // Samples of less weight than `min_color_weight` have no colour.
  // `thread`: number of the thread, for the grid.
  FusedTile(const FieldLayout& layout,
            const RaySamplingParameters& sampling,
            float min_color_weight,
            int thread);

  // `random`: see SampleTile.
  void Forward(const FusedField& field,
               const RayTile& rays,
               Random* random,
               bool with_color,
               RayOutputs* outputs);

  // Of the rays rendered last.
  RaySamples Samples() const;

  // A buffer of zeros for further derivatives by the weights of Samples().
  float* ClearedWeightGradient();

  // For the rays rendered last, with colour. Adds the gradient by the network's
  // parameters to `network_gradient`; that by the encoding is in DEncoding().
  //   d_weight: further derivatives by the weights of Samples(), or null.
  void Backward(const FusedField& field,
                const RayTile& rays,
                const RayOutputs& outputs,
                const RayGradients& gradients,
                const float* d_weight,
                float* network_gradient);

  // Raw density at points in field coordinates, at most kMaxTileRays *
  // num_samples. Reads up to 15 numbers beyond the end of the positions.
  void EvaluateDensity(const FusedField& field,
                       const float* x,
                       const float* y,
                       const float* z,
                       size_t num_points,
                       float* raw_density);

  // Of the rays rendered last.
  size_t NumSamples() const { return num_samples_; }
  size_t NumColorSamples() const { return num_active_; }
  const float* Position(const int axis) const { return position_[axis].data(); }
  const float* DEncoding() const { return network_.d_encoding.data(); }
  void CopyRawDensity(float* raw_density) const;

  int Thread() const { return thread_; }

  StageClock* Clock() { return &clock_; }

  // What this thread has done.
  WorkCounts* Work() { return &work_; }

 private:
  void ForwardColor(const FusedField& field,
                    const RayTile& rays,
                    RayOutputs* outputs);
  CompositeInputs MakeCompositeInputs(const RayTile& rays) const;
  CompositeSamples MakeCompositeSamples();

  const RaySamplingParameters sampling_;
  const float min_color_weight_;
  const int thread_;
  const int num_harmonics_;
  StageClock clock_;
  WorkCounts work_;

  size_t num_samples_ = 0;
  FusedNetwork::Buffers network_;
  AlignedBuffer<float> edges_;
  AlignedBuffer<float> position_[3];

  // See CompositeSamples.
  AlignedBuffer<float> tau_;
  AlignedBuffer<float> transmittance_;
  AlignedBuffer<float> weight_;
  AlignedBuffer<float> z_;
  AlignedBuffer<float> d_weight_color_;
  AlignedBuffer<float> d_weight_;  // see ClearedWeightGradient()

  // See FusedNetwork::ActiveSamples.
  AlignedBuffer<uint32_t> active_samples_;
  AlignedBuffer<uint32_t> active_rays_;
  size_t num_active_ = 0;
  AlignedBuffer<float> ray_color_;    // rays x kRayColorWidth
  AlignedBuffer<float> d_ray_color_;  // rays x kRayColorWidth
};

}  // namespace structnerf
