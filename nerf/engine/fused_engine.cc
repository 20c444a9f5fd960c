#include "nerf/engine/fused_grid.h"
#include "nerf/engine/fused_network.h"
#include "nerf/engine/render_engine.h"
#include "nerf/engine/tile_sampling.h"
#include "nerf/kernels/adam.h"
#include "nerf/kernels/compositing.h"
#include "nerf/util/aligned_buffer.h"
#include "nerf/util/thread_pool.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include <hwy/base.h>

namespace structnerf {
namespace {

// Cells of the density cache that are evaluated per task.
constexpr size_t kRefreshChunk = 512;

// What one thread needs to render a tile, allocated once.
struct TileBuffers {
  TileBuffers(const FieldLayout& layout, const size_t num_samples)
      : network(layout, kMaxTileRays * num_samples),
        edges(kMaxTileRays * (num_samples + 1)),
        position{AlignedBuffer<float>(kMaxTileRays * num_samples + 16),
                 AlignedBuffer<float>(kMaxTileRays * num_samples + 16),
                 AlignedBuffer<float>(kMaxTileRays * num_samples + 16)},
        tau(kMaxTileRays * num_samples),
        transmittance(kMaxTileRays * num_samples),
        weight(kMaxTileRays * num_samples),
        z(kMaxTileRays * num_samples),
        d_weight_color(kMaxTileRays * num_samples),
        d_encoding(kMaxTileRays * num_samples * layout.encoding_width),
        active(kMaxTileRays * num_samples),
        direction(kMaxTileRays * kDirectionWidth) {}

  FusedNetwork::Buffers network;
  AlignedBuffer<float> edges;
  AlignedBuffer<float> position[3];
  AlignedBuffer<float> tau;
  AlignedBuffer<float> transmittance;
  AlignedBuffer<float> weight;
  AlignedBuffer<float> z;
  AlignedBuffer<float> d_weight_color;
  AlignedBuffer<float> d_encoding;
  AlignedBuffer<uint32_t> active;  // samples whose colour is evaluated
  AlignedBuffer<float> direction;  // rays x kDirectionWidth
  PerRay<float> color_weight;      // sum of the weights of active samples
};

class FusedEngine : public RenderEngine {
 public:
  explicit FusedEngine(const EngineOptions& options)
      : options_(options),
        layout_(options.field, options.extent),
        network_(layout_),
        cache_(options.sampling.cache_resolution,
               options.extent,
               options.initial_density),
        pool_(options.num_threads),
        grid_(layout_,
              kMaxTileRays * options.sampling.num_samples,
              pool_.NumThreads()) {
    sampling_.num_bins = options.sampling.num_bins;
    sampling_.num_samples = options.sampling.num_samples;
    sampling_.uniform_share =
        static_cast<float>(options.sampling.uniform_share);
    for (int i = 0; i < pool_.NumThreads(); ++i) {
      buffers_.push_back(
          std::make_unique<TileBuffers>(layout_, sampling_.num_samples));
    }
    network_gradient_.Allocate(layout_.num_network_parameters);
    network_first_moment_.Allocate(layout_.num_network_parameters);
    network_second_moment_.Allocate(layout_.num_network_parameters);
    SetParameters(
        InitialParameters(layout_, options.initial_density, options.seed));
  }

  const FieldLayout& Layout() const override { return layout_; }

  const DensityCache& Cache() const override { return cache_; }

  int NumThreads() const override { return pool_.NumThreads(); }

  LossValues Accumulate(
      const StepParameters& step,
      const std::vector<std::unique_ptr<TileObjective>>& objectives) override {
    level_weights_ = step.level_weights;
    ReserveTiles(step.num_tiles);
    first_grid_tile_ = grid_.AddTiles(step.num_tiles);
    pool_.ParallelFor(step.num_tiles, [&](const size_t tile, const int thread) {
      AccumulateTile(
          step, static_cast<int>(tile), objectives[thread].get(), thread);
    });
    LossValues losses = {};
    for (int tile = 0; tile < step.num_tiles; ++tile) {
      const size_t first = tile * TileSamples();
      cache_.Observe(step_position_[0].data() + first,
                     step_position_[1].data() + first,
                     step_position_[2].data() + first,
                     step_density_.data() + first,
                     tile_num_samples_[tile],
                     static_cast<float>(options_.sampling.cache_decay));
      for (size_t term = 0; term < losses.size(); ++term) {
        losses[term] += tile_losses_[tile][term];
      }
      const float* const gradient = tile_network_gradients_.data() +
                                    tile * layout_.num_network_parameters;
      for (size_t i = 0; i < layout_.num_network_parameters; ++i) {
        network_gradient_[i] += gradient[i];
      }
    }
    return losses;
  }

  bool Update(const float grid_learning_rate,
              const float network_learning_rate) override {
    ++num_updates_;
    AdamStep step;
    // Bias correction for parameters that are updated in every step. Entries of
    // the grid that are touched less often need none: with these betas their
    // first update has the size of the learning rate as it is.
    const double correction1 = 1 - std::pow(step.beta1, num_updates_);
    const double correction2 = 1 - std::pow(step.beta2, num_updates_);
    step.learning_rate = grid_learning_rate;
    const bool grid_finite = grid_.Update(step, &pool_);
    bool network_finite = true;
    for (size_t i = 0; i < layout_.num_network_parameters; ++i) {
      network_finite &= std::abs(network_gradient_[i]) < kMaxGradient;
    }
    if (network_finite) {
      step.learning_rate = static_cast<float>(
          network_learning_rate * std::sqrt(correction2) / correction1);
      AdamUpdate(step,
                 layout_.num_network_parameters,
                 network_gradient_.data(),
                 network_first_moment_.data(),
                 network_second_moment_.data(),
                 network_values_.data());
      network_.SetParameters(network_values_.data());
    }
    std::fill(network_gradient_.data(),
              network_gradient_.data() + network_gradient_.size(),
              0.0f);
    return grid_finite && network_finite;
  }

  void RefreshDensityCache(const float decay) override {
    const size_t count =
        std::min(DensityCache::kRefreshCells, cache_.NumCells());
    for (AlignedBuffer<float>& position : refresh_position_) {
      if (position.size() < count + 16) {
        position.Allocate(count + 16);
      }
    }
    refresh_density_.resize(count);
    cache_.NextPoints(count,
                      refresh_position_[0].data(),
                      refresh_position_[1].data(),
                      refresh_position_[2].data());
    const size_t chunk_size =
        std::min<size_t>(kRefreshChunk, kMaxTileRays * sampling_.num_samples);
    pool_.ParallelFor((count + chunk_size - 1) / chunk_size,
                      [&](const size_t chunk, const int thread) {
                        const size_t begin = chunk * chunk_size;
                        const size_t size = std::min(chunk_size, count - begin);
                        TileBuffers& buffers = *buffers_[thread];
                        grid_.Encode(refresh_position_[0].data() + begin,
                                     refresh_position_[1].data() + begin,
                                     refresh_position_[2].data() + begin,
                                     size,
                                     level_weights_,
                                     thread,
                                     buffers.network.encoding.data());
                        network_.ForwardDensity(size, &buffers.network);
                        for (size_t i = 0; i < size; ++i) {
                          refresh_density_[begin + i] =
                              buffers.network.geometry[i * kGeometryWidth];
                        }
                      });
    cache_.Update(refresh_density_.data(), count, decay);
  }

  void Render(const std::vector<RayTile>& tiles,
              const bool with_color,
              std::vector<RayOutputs>* outputs) override {
    outputs->resize(tiles.size());
    pool_.ParallelFor(tiles.size(), [&](const size_t tile, const int thread) {
      TileBuffers& buffers = *buffers_[thread];
      ForwardTile(tiles[tile],
                  nullptr,
                  with_color,
                  thread,
                  &buffers,
                  &(*outputs)[tile]);
    });
  }

  FieldParameters Parameters() const override {
    FieldParameters parameters;
    parameters.grid = grid_.Parameters();
    ApplyLevelWeights(layout_, level_weights_, &parameters.grid);
    parameters.network.assign(network_values_.data(),
                              network_values_.data() + network_values_.size());
    return parameters;
  }

  void SetParameters(const FieldParameters& parameters) override {
    grid_.SetParameters(parameters.grid);
    level_weights_.clear();
    network_values_.Allocate(layout_.num_network_parameters);
    std::copy(parameters.network.begin(),
              parameters.network.end(),
              network_values_.data());
    network_.SetParameters(network_values_.data());
  }

  FieldParameters Gradients() const override {
    FieldParameters gradients;
    gradients.grid = grid_.Gradients();
    gradients.network.assign(
        network_gradient_.data(),
        network_gradient_.data() + network_gradient_.size());
    return gradients;
  }

 protected:
  DensityCache* MutableCache() override { return &cache_; }

 private:
  size_t TileSamples() const { return kMaxTileRays * sampling_.num_samples; }

  void ReserveTiles(const int num_tiles) {
    if (num_tiles <= static_cast<int>(tile_losses_.size())) {
      return;
    }
    tile_losses_.resize(num_tiles);
    tile_num_samples_.resize(num_tiles);
    tile_network_gradients_.Allocate(num_tiles *
                                     layout_.num_network_parameters);
    for (AlignedBuffer<float>& position : step_position_) {
      position.Allocate(num_tiles * TileSamples() + 16);
    }
    step_density_.Allocate(num_tiles * TileSamples());
  }

  CompositeInputs MakeCompositeInputs(const RayTile& rays,
                                      const TileBuffers& buffers) const {
    CompositeInputs inputs;
    inputs.num_rays = rays.num_rays;
    inputs.num_samples = sampling_.num_samples;
    inputs.raw_density = buffers.network.geometry.data();
    inputs.raw_density_stride = kGeometryWidth;
    inputs.edges = buffers.edges.data();
    inputs.ray_length = rays.direction_norm.data();
    return inputs;
  }

  static CompositeSamples MakeCompositeSamples(TileBuffers* buffers) {
    return {buffers->tau.data(),
            buffers->transmittance.data(),
            buffers->weight.data(),
            buffers->z.data()};
  }

  // Returns the number of samples whose colour was evaluated.
  size_t ForwardTile(const RayTile& rays,
                     Random* random,
                     const bool with_color,
                     const int thread,
                     TileBuffers* buffers,
                     RayOutputs* outputs) const {
    const size_t n = sampling_.num_samples;
    const size_t num_samples = rays.num_rays * n;
    SampleTile(rays,
               cache_,
               sampling_,
               random,
               buffers->edges.data(),
               buffers->position[0].data(),
               buffers->position[1].data(),
               buffers->position[2].data());
    grid_.Encode(buffers->position[0].data(),
                 buffers->position[1].data(),
                 buffers->position[2].data(),
                 num_samples,
                 level_weights_,
                 thread,
                 buffers->network.encoding.data());
    network_.ForwardDensity(num_samples, &buffers->network);
    CompositeForward(MakeCompositeInputs(rays, *buffers),
                     MakeCompositeSamples(buffers),
                     outputs->depth.data(),
                     outputs->depth_variance.data(),
                     outputs->opacity.data());
    if (!with_color) {
      return 0;
    }
    size_t num_active = 0;
    for (size_t s = 0; s < num_samples; ++s) {
      buffers->active[num_active] = static_cast<uint32_t>(s);
      num_active += buffers->weight[s] >= options_.min_color_weight;
    }
    for (int ray = 0; ray < rays.num_rays; ++ray) {
      EncodeDirection(
          rays, ray, buffers->direction.data() + ray * kDirectionWidth);
    }
    network_.ForwardColor(buffers->active.data(),
                          num_active,
                          n,
                          buffers->direction.data(),
                          &buffers->network);
    for (PerRay<float>& channel : outputs->color) {
      channel.fill(0);
    }
    buffers->color_weight.fill(0);
    for (size_t a = 0; a < num_active; ++a) {
      const size_t s = buffers->active[a];
      const float* const color =
          buffers->network.color.data() + a * kColorOutputWidth;
      for (int c = 0; c < 3; ++c) {
        outputs->color[c][s / n] += buffers->weight[s] * color[c];
      }
      buffers->color_weight[s / n] += buffers->weight[s];
    }
    for (int ray = 0; ray < rays.num_rays; ++ray) {
      for (PerRay<float>& channel : outputs->color) {
        channel[ray] /= buffers->color_weight[ray];
      }
    }
    return num_active;
  }

  void AccumulateTile(const StepParameters& step,
                      const int tile,
                      TileObjective* objective,
                      const int thread) {
    TileBuffers& buffers = *buffers_[thread];
    const size_t n = sampling_.num_samples;
    RayTile rays;
    objective->DrawRays(step.step, tile, &rays);
    Random random(options_.seed, step.step, tile);
    RayOutputs outputs;
    const size_t num_active =
        ForwardTile(rays, &random, true, thread, &buffers, &outputs);
    RayGradients gradients;
    tile_losses_[tile] = objective->Evaluate(outputs, &gradients);

    const size_t num_samples = rays.num_rays * n;
    tile_num_samples_[tile] = num_samples;
    // Samples that are not active neither gain nor lose from colour.
    std::fill(buffers.d_weight_color.data(),
              buffers.d_weight_color.data() + num_samples,
              0.0f);
    float* const d_color = buffers.network.d_color.data();
    for (size_t a = 0; a < num_active; ++a) {
      const size_t s = buffers.active[a];
      const size_t ray = s / n;
      const float* const color =
          buffers.network.color.data() + a * kColorOutputWidth;
      const float share = 1.0f / buffers.color_weight[ray];
      float sum = 0;
      for (int c = 0; c < 3; ++c) {
        const float gradient = gradients.d_color[c][ray] * share;
        sum += gradient * (color[c] - outputs.color[c][ray]);
        // Through the sigmoid.
        d_color[a * kColorOutputWidth + c] =
            buffers.weight[s] * gradient * color[c] * (1 - color[c]);
      }
      std::fill(d_color + a * kColorOutputWidth + 3,
                d_color + (a + 1) * kColorOutputWidth,
                0.0f);
      buffers.d_weight_color[s] = sum;
    }

    float* const network_gradient =
        tile_network_gradients_.data() + tile * layout_.num_network_parameters;
    std::fill(network_gradient,
              network_gradient + layout_.num_network_parameters,
              0.0f);
    network_.BackwardColor(buffers.active.data(),
                           num_active,
                           num_samples,
                           &buffers.network,
                           network_gradient);
    CompositeGradients composite_gradients;
    composite_gradients.depth = outputs.depth.data();
    composite_gradients.d_depth = gradients.d_depth.data();
    composite_gradients.d_opacity = gradients.d_opacity.data();
    composite_gradients.pull = gradients.pull.data();
    composite_gradients.pull_z = gradients.pull_z.data();
    composite_gradients.d_weight_color = buffers.d_weight_color.data();
    CompositeBackward(MakeCompositeInputs(rays, buffers),
                      MakeCompositeSamples(&buffers),
                      composite_gradients,
                      buffers.network.d_raw_density.data());
    network_.BackwardDensity(num_samples,
                             &buffers.network,
                             network_gradient,
                             buffers.d_encoding.data());
    grid_.SetTileGradient(first_grid_tile_ + tile,
                          buffers.position[0].data(),
                          buffers.position[1].data(),
                          buffers.position[2].data(),
                          num_samples,
                          level_weights_,
                          buffers.d_encoding.data(),
                          thread);
    for (int axis = 0; axis < 3; ++axis) {
      std::copy(buffers.position[axis].data(),
                buffers.position[axis].data() + num_samples,
                step_position_[axis].data() + tile * TileSamples());
    }
    for (size_t s = 0; s < num_samples; ++s) {
      step_density_[tile * TileSamples() + s] =
          buffers.network.geometry[s * kGeometryWidth];
    }
  }

  const EngineOptions options_;
  const FieldLayout layout_;
  RaySamplingParameters sampling_;
  FusedNetwork network_;
  DensityCache cache_;
  ThreadPool pool_;
  FusedGrid grid_;
  size_t first_grid_tile_ = 0;  // of the current step

  std::vector<float> level_weights_;  // empty = all one
  AlignedBuffer<float> network_values_;
  AlignedBuffer<float> network_gradient_;
  AlignedBuffer<float> network_first_moment_;
  AlignedBuffer<float> network_second_moment_;
  int num_updates_ = 0;

  std::vector<std::unique_ptr<TileBuffers>> buffers_;  // per thread

  // Per tile of the current step, so that sums run in the order of the tiles.
  std::vector<LossValues> tile_losses_;
  std::vector<size_t> tile_num_samples_;
  AlignedBuffer<float> tile_network_gradients_;
  AlignedBuffer<float> step_position_[3];
  AlignedBuffer<float> step_density_;  // raw

  AlignedBuffer<float> refresh_position_[3];
  std::vector<float> refresh_density_;
};

}  // namespace

std::unique_ptr<RenderEngine> MakeFusedEngine(const EngineOptions& options) {
  return std::make_unique<FusedEngine>(options);
}

}  // namespace structnerf
