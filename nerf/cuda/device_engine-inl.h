#pragma once

#include "nerf/cuda/device_field-inl.h"
#include "nerf/engine/grid_engine.h"
#include "nerf/engine/tile_sampling.h"
#include "nerf/util/random.h"
#include "nerf/util/thread_pool.h"

#include <algorithm>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace structnerf {

// The grid's engine with its field on a device. Rays are drawn and sampled, and
// losses are taken, by threads of the host, which also keeps the density cache;
// the field is evaluated, differentiated and updated on the device, with the
// kernels of this folder. See DeviceBuffer for what a Device is.
//
// The gradient by the grid is summed in no order on a device with threads:
// there, results differ in the last bits from run to run.
template <class Device>
class DeviceEngine : public GridEngine {
 public:
  // `warn` is told, in a sentence, when the device's memory makes batches
  // smaller. Throws DeviceOutOfMemory if it does not even hold the field; later
  // calls do if it does not hold one tile beside it.
  DeviceEngine(const EngineOptions& options,
               std::unique_ptr<Device> device,
               std::function<void(const std::string&)> warn)
      : options_(options),
        layout_(options.field, options.extent),
        device_(std::move(device)),
        warn_(std::move(warn)),
        sampling_(MakeSamplingParameters(options.sampling)),
        pool_(options.num_threads),
        field_(layout_, options.min_color_weight, device_.get()),
        batch_(std::make_unique<Batch>(device_.get())),
        cache_(MakeCache(options)) {
    SetParameters(
        InitialParameters(layout_, options.initial_density, options.seed));
  }

  const FieldLayout& Layout() const override { return layout_; }
  const DensityCache& Cache() const override { return cache_; }
  int NumThreads() const override { return pool_.NumThreads(); }
  WorkCounts Work() const override { return work_; }

  LossValues Accumulate(
      const StepParameters& step,
      const std::vector<std::unique_ptr<TileObjective>>& objectives) override {
    level_weights_ = step.level_weights;
    LossValues losses = {};
    ForEachBatch(step.num_tiles, [&](const size_t first, const size_t count) {
      AddLosses(AccumulateTiles(step.step, first, count, objectives), &losses);
    });
    return losses;
  }

  bool Update(const float grid_learning_rate,
              const float network_learning_rate) override {
    ++num_updates_;
    ObserveDensity();
    return field_.Update(
        grid_learning_rate,
        BiasCorrectedRate(network_learning_rate, num_updates_));
  }

  void RefreshDensityCache(const float decay) override {
    const size_t count =
        std::min(DensityCache::kRefreshCells, cache_.NumCells());
    const size_t first_visit = cache_.NextVisits(count);
    const size_t tile_points = kMaxTileRays * sampling_.num_samples;
    const size_t num_tiles = (count + tile_points - 1) / tile_points;
    ForEachBatch(num_tiles, [&](const size_t first, const size_t num) {
      const size_t begin = first * tile_points;
      RefreshPoints(first_visit + begin,
                    std::min(num * tile_points, count - begin),
                    decay);
    });
  }

  void Render(const std::vector<RayTile>& tiles,
              const bool with_color,
              std::vector<RayOutputs>* outputs) override {
    outputs->resize(tiles.size());
    ForEachBatch(tiles.size(), [&](const size_t first, const size_t count) {
      const size_t num_rays = SampleTiles(tiles.data() + first, count, nullptr);
      if (num_rays == 0) {
        return;
      }
      ForwardRays(num_rays, with_color, /*with_gradient=*/false);
      for (size_t i = 0; i < count; ++i) {
        CopyOutputs(host_.first_ray[i],
                    tiles[first + i].num_rays,
                    with_color,
                    &(*outputs)[first + i]);
      }
    });
  }

  FieldParameters Parameters() const override {
    FieldParameters parameters = MasterParameters();
    ApplyLevelWeights(layout_, level_weights_, &parameters.grid);
    return parameters;
  }

  FieldParameters MasterParameters() const override {
    return field_.Parameters();
  }

  void SetParameters(const FieldParameters& parameters) override {
    level_weights_.clear();
    field_.SetParameters(parameters);
  }

  void Restore(const FieldParameters& parameters) override {
    SetParameters(parameters);
    field_.ClearMoments();
    num_updates_ = 0;
    cache_ = MakeCache(options_);
  }

  void Restart(const int seed) override {
    Restore(InitialParameters(layout_, options_.initial_density, seed));
  }

  void SaveState(StateWriter* writer) const override {
    SaveHead(layout_, level_weights_, num_updates_, writer);
    field_.SaveState(writer);
    cache_.SaveState(writer);
  }

  void LoadState(StateReader* reader) override {
    LoadHead(layout_, reader, &level_weights_, &num_updates_);
    field_.LoadState(reader);
    cache_.LoadState(reader);
  }

  FieldParameters Gradients() const override { return field_.Gradients(); }

 protected:
  DensityCache* MutableCache() override { return &cache_; }

 private:
  using Batch = DeviceBatch<Device>;

  // Tiles in the memory of the device at a time, if it suffices.
  static constexpr size_t kMaxBatchTiles = 256;

  // Points of the density cache per task.
  static constexpr size_t kChunk = 2048;

  // Inputs and results of the batch on the host.
  struct HostBatch {
    std::vector<size_t> first_ray;  // of each tile
    std::vector<float> positions[3];
    std::vector<float> edges;
    std::vector<float> ray_length;
    std::vector<float> direction;
    std::vector<float> depth;
    std::vector<float> depth_variance;
    std::vector<float> opacity;
    std::vector<float> ray_color;
    std::vector<float> weight;
    std::vector<float> ray_gradients;
    std::vector<float> d_weight;
  };

  // Calls work(first, count) for batches of tiles. A batch for which memory
  // does not suffice, which `work` must find out before it changes anything, is
  // halved, and so are all that follow.
  template <typename Work>
  void ForEachBatch(const size_t num_tiles, const Work& work) {
    size_t first = 0;
    bool is_new_batch = false;
    while (first < num_tiles) {
      const size_t count = std::min(batch_tiles_, num_tiles - first);
      try {
        work(first, count);
        first += count;
        is_new_batch = false;
      } catch (const DeviceOutOfMemory&) {
        // The first time, buffers of another kind of work may be in the way.
        if (is_new_batch) {
          if (count == 1) {
            throw;
          }
          batch_tiles_ = count / 2;
          warn_("The memory of the graphics card does not suffice for " +
                std::to_string(count * kMaxTileRays) +
                " rays at a time; going on with " +
                std::to_string(batch_tiles_ * kMaxTileRays) + ".");
        }
        batch_ = std::make_unique<Batch>(device_.get());
        is_new_batch = true;
      }
    }
  }

  template <typename Body>
  void ForEachChunk(const size_t count, const Body& body) {
    pool_.ParallelFor((count + kChunk - 1) / kChunk,
                      [&](const size_t chunk, int /*thread*/) {
                        const size_t begin = chunk * kChunk;
                        body(begin, std::min(kChunk, count - begin));
                      });
  }

  // Of a training step. Returns the sum of the losses.
  LossValues AccumulateTiles(
      const int step,
      const size_t first_tile,
      const size_t num_tiles,
      const std::vector<std::unique_ptr<TileObjective>>& objectives) {
    const StepTiles step_tiles = {step, first_tile};
    tiles_.resize(num_tiles);
    pool_.ParallelFor(num_tiles, [&](const size_t i, const int thread) {
      objectives[thread]->DrawRays(
          step, static_cast<int>(first_tile + i), &tiles_[i]);
    });
    const size_t num_rays = SampleTiles(tiles_.data(), num_tiles, &step_tiles);
    if (num_rays == 0) {
      return {};
    }
    ForwardRays(num_rays, /*with_color=*/true, /*with_gradient=*/true);
    const LossValues losses = Evaluate(step_tiles, objectives);
    KeepDensity();
    batch_->ray_gradients.Upload(host_.ray_gradients);
    batch_->d_weight.Upload(host_.d_weight);
    field_.Backward(level_weights_, batch_.get());
    work_.num_rays += num_rays;
    work_.num_samples += batch_->NumSamples();
    work_.num_color_samples += batch_->NumSamples();
    work_.num_gradient_samples += batch_->NumSamples();
    return losses;
  }

  // Evaluates points of the density cache and tells it.
  void RefreshPoints(const size_t first_visit,
                     const size_t count,
                     const float decay) {
    batch_->ReservePoints(layout_, count, /*new_samples_per_ray=*/1);
    for (std::vector<float>& position : host_.positions) {
      position.resize(count);
    }
    ForEachChunk(count, [&](const size_t begin, const size_t size) {
      cache_.VisitPoints(first_visit + begin,
                         size,
                         host_.positions[0].data() + begin,
                         host_.positions[1].data() + begin,
                         host_.positions[2].data() + begin);
    });
    EvaluateDensity();
    const std::vector<float> raw_density = batch_->raw_density.Download(count);
    ForEachChunk(count, [&](const size_t begin, const size_t size) {
      cache_.Update(
          first_visit + begin, raw_density.data() + begin, size, decay);
    });
  }

  // Tiles of a training step, from a first one on.
  struct StepTiles {
    int step;
    size_t first_tile;
  };

  // Samples the rays of tiles, jittered if they belong to a training step.
  // Returns the number of rays.
  size_t SampleTiles(const RayTile* tiles,
                     const size_t num_tiles,
                     const StepTiles* step_tiles) {
    const size_t n = sampling_.num_samples;
    host_.first_ray.resize(num_tiles);
    size_t num_rays = 0;
    for (size_t i = 0; i < num_tiles; ++i) {
      host_.first_ray[i] = num_rays;
      num_rays += tiles[i].num_rays;
    }
    host_.edges.resize(num_rays * (n + 1));
    for (std::vector<float>& position : host_.positions) {
      position.resize(num_rays * n);
    }
    host_.ray_length.resize(num_rays);
    host_.direction.resize(num_rays * kDirectionWidth);
    pool_.ParallelFor(num_tiles, [&](const size_t i, int /*thread*/) {
      const RayTile& rays = tiles[i];
      const size_t first = host_.first_ray[i];
      const StepTiles numbers =
          step_tiles != nullptr ? *step_tiles : StepTiles{0, 0};
      Random random(options_.seed, numbers.step, numbers.first_tile + i);
      SampleTile(rays,
                 cache_,
                 sampling_,
                 step_tiles != nullptr ? &random : nullptr,
                 host_.edges.data() + first * (n + 1),
                 host_.positions[0].data() + first * n,
                 host_.positions[1].data() + first * n,
                 host_.positions[2].data() + first * n);
      for (int ray = 0; ray < rays.num_rays; ++ray) {
        host_.ray_length[first + ray] = rays.direction_norm[ray];
        EncodeDirection(
            rays,
            ray,
            layout_.num_harmonics,
            host_.direction.data() + (first + ray) * kDirectionWidth);
      }
    });
    return num_rays;
  }

  // From host_.positions to raw density on the device.
  void EvaluateDensity() {
    for (int axis = 0; axis < 3; ++axis) {
      batch_->positions[axis].Upload(host_.positions[axis]);
    }
    field_.ForwardDensity(level_weights_, batch_.get());
  }

  // Renders what SampleTiles() has left, and fetches the results.
  void ForwardRays(const size_t num_rays,
                   const bool with_color,
                   const bool with_gradient) {
    Batch& batch = *batch_;
    batch.ReserveRays(layout_, num_rays, sampling_.num_samples, with_gradient);
    batch.edges.Upload(host_.edges);
    batch.ray_length.Upload(host_.ray_length);
    batch.direction.Upload(host_.direction);
    EvaluateDensity();
    field_.ForwardRays(with_color, &batch);
    host_.depth = batch.depth.Download(num_rays);
    host_.depth_variance = batch.depth_variance.Download(num_rays);
    host_.opacity = batch.opacity.Download(num_rays);
    if (with_color) {
      host_.ray_color = batch.ray_color.Download(num_rays * kRayColorWidth);
    }
  }

  void CopyOutputs(const size_t first_ray,
                   const int num_rays,
                   const bool with_color,
                   RayOutputs* outputs) const {
    for (int ray = 0; ray < num_rays; ++ray) {
      const size_t i = first_ray + ray;
      outputs->depth[ray] = host_.depth[i];
      outputs->depth_variance[ray] = host_.depth_variance[i];
      outputs->opacity[ray] = host_.opacity[i];
      for (size_t c = 0; with_color && c < kNumColorChannels; ++c) {
        outputs->color[c][ray] = host_.ray_color[i * kRayColorWidth + c];
      }
    }
  }

  // What the density cache will be told at the update: until then, all steps
  // are sampled alike.
  void KeepDensity() {
    for (int axis = 0; axis < 3; ++axis) {
      seen_positions_[axis].insert(seen_positions_[axis].end(),
                                   host_.positions[axis].begin(),
                                   host_.positions[axis].end());
    }
    const std::vector<float> raw_density =
        batch_->raw_density.Download(batch_->NumSamples());
    seen_density_.insert(
        seen_density_.end(), raw_density.begin(), raw_density.end());
  }

  void ObserveDensity() {
    cache_.Observe(seen_positions_[0].data(),
                   seen_positions_[1].data(),
                   seen_positions_[2].data(),
                   seen_density_.data(),
                   seen_density_.size(),
                   static_cast<float>(options_.sampling.cache_decay));
    for (std::vector<float>& positions : seen_positions_) {
      positions.clear();
    }
    seen_density_.clear();
  }

  // Lets the objectives judge tiles_. An objective judges the rays it drew
  // last, so they are drawn again.
  LossValues Evaluate(
      const StepTiles& step_tiles,
      const std::vector<std::unique_ptr<TileObjective>>& objectives) {
    const size_t n = sampling_.num_samples;
    const size_t num_rays = batch_->num_rays;
    host_.weight = batch_->weight.Download(num_rays * n);
    host_.ray_gradients.resize(num_rays * kNumRayGradients);
    host_.d_weight.assign(num_rays * n, 0.0f);
    std::vector<LossValues> tile_losses(tiles_.size());
    pool_.ParallelFor(tiles_.size(), [&](const size_t i, const int thread) {
      TileObjective& objective = *objectives[thread];
      RayTile& rays = tiles_[i];
      objective.DrawRays(
          step_tiles.step, static_cast<int>(step_tiles.first_tile + i), &rays);
      const size_t first = host_.first_ray[i];
      RayOutputs outputs;
      CopyOutputs(first, rays.num_rays, /*with_color=*/true, &outputs);
      RayGradients gradients;
      tile_losses[i] = objective.Evaluate(outputs, &gradients);
      if (objective.UsesSamples()) {
        AddLosses(
            objective.EvaluateSamples({sampling_.num_samples,
                                       host_.edges.data() + first * (n + 1),
                                       host_.weight.data() + first * n},
                                      host_.d_weight.data() + first * n),
            &tile_losses[i]);
      }
      float* const d_color = host_.ray_gradients.data();
      float* const d_rest = d_color + num_rays * kNumColorChannels;
      for (int ray = 0; ray < rays.num_rays; ++ray) {
        const size_t k = first + ray;
        for (size_t c = 0; c < kNumColorChannels; ++c) {
          d_color[k * kNumColorChannels + c] = gradients.d_color[c][ray];
        }
        d_rest[k] = gradients.d_depth[ray];
        d_rest[num_rays + k] = gradients.d_opacity[ray];
        d_rest[2 * num_rays + k] = gradients.pull[ray];
        d_rest[3 * num_rays + k] = gradients.pull_z[ray];
      }
    });
    LossValues losses = {};
    for (const LossValues& tile_loss : tile_losses) {
      AddLosses(tile_loss, &losses);
    }
    return losses;
  }

  const EngineOptions options_;
  const FieldLayout layout_;
  const std::unique_ptr<Device> device_;
  const std::function<void(const std::string&)> warn_;
  const RaySamplingParameters sampling_;
  ThreadPool pool_;
  DeviceField<Device> field_;
  std::unique_ptr<Batch> batch_;
  size_t batch_tiles_ = kMaxBatchTiles;
  HostBatch host_;
  std::vector<RayTile> tiles_;
  DensityCache cache_;
  std::vector<float> seen_positions_[3];  // since the last update
  std::vector<float> seen_density_;
  std::vector<float> level_weights_;  // empty = all one
  int num_updates_ = 0;
  WorkCounts work_;
};

}  // namespace structnerf
