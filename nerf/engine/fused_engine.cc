#include "nerf/engine/fused_grid.h"
#include "nerf/engine/fused_network.h"
#include "nerf/engine/fused_tile.h"
#include "nerf/engine/grid_engine.h"
#include "nerf/kernels/adam.h"
#include "nerf/kernels/dense_layer.h"
#include "nerf/util/aligned_buffer.h"
#include "nerf/util/thread_pool.h"

#include <algorithm>
#include <atomic>
#include <cmath>

namespace structnerf {
namespace {

// Cells of the density cache that are evaluated per task.
constexpr size_t kRefreshChunk = 512;

// What a tile leaves behind until the update, besides the grid's gradient. Sums
// over tiles then run in the order of the tiles.
struct TileResult {
  TileResult(const size_t max_samples, const size_t num_network_parameters)
      : position{AlignedBuffer<float>(max_samples),
                 AlignedBuffer<float>(max_samples),
                 AlignedBuffer<float>(max_samples)},
        raw_density(max_samples),
        network_gradient(num_network_parameters) {}

  LossValues losses = {};
  size_t num_samples = 0;
  AlignedBuffer<float> position[3];
  AlignedBuffer<float> raw_density;
  AlignedBuffer<float> network_gradient;
};

class FusedEngine : public GridEngine {
 public:
  explicit FusedEngine(const EngineOptions& options)
      : options_(options),
        layout_(options.field, options.extent),
        sampling_(MakeSamplingParameters(options.sampling)),
        pool_(options.num_threads),
        network_(layout_),
        grid_(layout_, MaxTileSamples(), pool_.NumThreads()),
        cache_(MakeCache(options)),
        network_values_(layout_.num_network_parameters),
        network_gradient_(layout_.num_network_parameters),
        network_first_moment_(layout_.num_network_parameters),
        network_root_second_moment_(layout_.num_network_parameters) {
    for (int thread = 0; thread < pool_.NumThreads(); ++thread) {
      tiles_.push_back(std::make_unique<FusedTile>(
          layout_, sampling_, options.min_color_weight, thread));
      for (AlignedBuffer<float>& buffer : refresh_buffers_.emplace_back()) {
        buffer.Allocate(kRefreshChunk + 16);
      }
    }
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
    const size_t first = grid_.AddTiles(step.num_tiles);
    num_results_ = first + step.num_tiles;
    while (results_.size() < num_results_) {
      results_.push_back(std::make_unique<TileResult>(
          MaxTileSamples(), layout_.num_network_parameters));
    }
    pool_.ParallelFor(step.num_tiles, [&](const size_t tile, const int thread) {
      AccumulateTile(step,
                     static_cast<int>(tile),
                     first + tile,
                     objectives[thread].get(),
                     tiles_[thread].get());
    });
    LossValues losses = {};
    for (size_t i = first; i < num_results_; ++i) {
      AddLosses(results_[i]->losses, &losses);
    }
    return losses;
  }

  bool Update(const float grid_learning_rate,
              const float network_learning_rate) override {
    ++num_updates_;
    // Entries of the grid that are touched less often than in every step need
    // no bias correction: with these betas their first update has the size of
    // the learning rate as it is.
    AdamStep step;
    step.learning_rate = grid_learning_rate;
    std::atomic<bool> is_finite = true;
    // The network and the density cache are two more tasks among the many of
    // the grid.
    constexpr size_t kNumOtherTasks = 2;
    pool_.ParallelFor(grid_.NumBuckets() + kNumOtherTasks,
                      [&](const size_t task, const int thread) {
                        StageClock* const clock = tiles_[thread]->Clock();
                        bool task_finite = true;
                        if (task == 0) {
                          clock->Start();
                          task_finite = UpdateNetwork(network_learning_rate);
                          clock->Stop(EngineStage::kUpdateNetwork);
                        } else if (task == 1) {
                          clock->Start();
                          ObserveDensity();
                          clock->Stop(EngineStage::kObserveDensity);
                        } else {
                          task_finite = grid_.UpdateBucket(
                              task - kNumOtherTasks, step, thread, clock);
                        }
                        if (!task_finite) {
                          is_finite = false;
                        }
                      });
    grid_.ClearTiles();
    num_results_ = 0;
    return is_finite;
  }

  void RefreshDensityCache(const float decay) override {
    const size_t count =
        std::min(DensityCache::kRefreshCells, cache_.NumCells());
    const size_t first_visit = cache_.NextVisits(count);
    const size_t chunk_size = std::min(kRefreshChunk, MaxTileSamples());
    pool_.ParallelFor(
        (count + chunk_size - 1) / chunk_size,
        [&](const size_t chunk, const int thread) {
          StageClock* const clock = tiles_[thread]->Clock();
          clock->Start();
          const size_t begin = chunk * chunk_size;
          const size_t size = std::min(chunk_size, count - begin);
          RefreshBuffers& buffers = refresh_buffers_[thread];
          float* const x = buffers[0].data();
          float* const y = buffers[1].data();
          float* const z = buffers[2].data();
          float* const raw_density = buffers[3].data();
          cache_.VisitPoints(first_visit + begin, size, x, y, z);
          tiles_[thread]->EvaluateDensity(Field(), x, y, z, size, raw_density);
          cache_.Update(first_visit + begin, raw_density, size, decay);
          clock->Stop(EngineStage::kObserveDensity);
        });
  }

  void Render(const std::vector<RayTile>& tiles,
              const bool with_color,
              std::vector<RayOutputs>* outputs) override {
    outputs->resize(tiles.size());
    pool_.ParallelFor(tiles.size(), [&](const size_t tile, const int thread) {
      tiles_[thread]->Forward(
          Field(), tiles[tile], nullptr, with_color, &(*outputs)[tile]);
    });
  }

  FieldParameters Parameters() const override {
    FieldParameters parameters = MasterParameters();
    ApplyLevelWeights(layout_, level_weights_, &parameters.grid);
    return parameters;
  }

  FieldParameters MasterParameters() const override {
    FieldParameters parameters;
    parameters.grid = grid_.Parameters();
    parameters.network.assign(network_values_.data(),
                              network_values_.data() + network_values_.size());
    return parameters;
  }

  void SetParameters(const FieldParameters& parameters) override {
    grid_.SetParameters(parameters.grid);
    level_weights_.clear();
    std::copy(parameters.network.begin(),
              parameters.network.end(),
              network_values_.data());
    network_.SetParameters(network_values_.data());
  }

  void Restore(const FieldParameters& parameters) override {
    SetParameters(parameters);
    grid_.ClearMoments();
    for (AlignedBuffer<float>* moments :
         {&network_first_moment_, &network_root_second_moment_}) {
      std::fill(moments->data(), moments->data() + moments->size(), 0.0f);
    }
    num_updates_ = 0;
    cache_ = MakeCache(options_);
  }

  void Restart(const int seed) override {
    Restore(InitialParameters(layout_, options_.initial_density, seed));
  }

  void SaveState(StateWriter* writer) const override {
    SaveHead(layout_, level_weights_, num_updates_, writer);
    grid_.SaveState(writer);
    for (const AlignedBuffer<float>* buffer : {&network_values_,
                                               &network_first_moment_,
                                               &network_root_second_moment_}) {
      writer->Write(buffer->data(), buffer->size() * sizeof(float));
    }
    cache_.SaveState(writer);
  }

  void LoadState(StateReader* reader) override {
    LoadHead(layout_, reader, &level_weights_, &num_updates_);
    grid_.LoadState(reader);
    for (AlignedBuffer<float>* buffer : {&network_values_,
                                         &network_first_moment_,
                                         &network_root_second_moment_}) {
      reader->Read(buffer->data(), buffer->size() * sizeof(float));
    }
    network_.SetParameters(network_values_.data());
    cache_.LoadState(reader);
  }

  FieldParameters Gradients() const override {
    FieldParameters gradients;
    gradients.grid = grid_.Gradients();
    gradients.network.assign(layout_.num_network_parameters, 0.0f);
    SumNetworkGradients(gradients.network.data());
    return gradients;
  }

  StageSeconds Profile() const override {
    StageSeconds seconds = {};
    for (const std::unique_ptr<FusedTile>& tile : tiles_) {
      for (size_t stage = 0; stage < seconds.size(); ++stage) {
        seconds[stage] += tile->Clock()->Seconds()[stage];
      }
    }
    return seconds;
  }

  WorkCounts Work() const override {
    WorkCounts sum;
    for (const std::unique_ptr<FusedTile>& tile : tiles_) {
      const WorkCounts& work = *tile->Work();
      sum.num_rays += work.num_rays;
      sum.num_samples += work.num_samples;
      sum.num_color_samples += work.num_color_samples;
      sum.num_gradient_samples += work.num_gradient_samples;
    }
    return sum;
  }

 protected:
  DensityCache* MutableCache() override { return &cache_; }

 private:
  size_t MaxTileSamples() const {
    return static_cast<size_t>(kMaxTileRays) * sampling_.num_samples;
  }

  FusedField Field() const { return {grid_, network_, cache_, level_weights_}; }

  void AccumulateTile(const StepParameters& step,
                      const int tile_idx,
                      const size_t result_idx,
                      TileObjective* objective,
                      FusedTile* tile) {
    TileResult& result = *results_[result_idx];
    StageClock* const clock = tile->Clock();
    clock->Start();
    RayTile rays;
    objective->DrawRays(step.step, tile_idx, &rays);
    clock->Stop(EngineStage::kRays);

    Random random(options_.seed, step.step, tile_idx);
    RayOutputs outputs;
    tile->Forward(Field(), rays, &random, /*with_color=*/true, &outputs);
    RayGradients gradients;
    result.losses = objective->Evaluate(outputs, &gradients);
    const float* d_weight = nullptr;
    if (objective->UsesSamples()) {
      float* const buffer = tile->ClearedWeightGradient();
      AddLosses(objective->EvaluateSamples(tile->Samples(), buffer),
                &result.losses);
      d_weight = buffer;
    }
    clock->Stop(EngineStage::kLosses);

    std::fill(result.network_gradient.data(),
              result.network_gradient.data() + result.network_gradient.size(),
              0.0f);
    tile->Backward(Field(),
                   rays,
                   outputs,
                   gradients,
                   d_weight,
                   result.network_gradient.data());
    const size_t num_gradient_samples =
        grid_.SetTileGradient(result_idx,
                              tile->Position(0),
                              tile->Position(1),
                              tile->Position(2),
                              tile->NumSamples(),
                              level_weights_,
                              tile->DEncoding(),
                              tile->Thread());
    clock->Stop(EngineStage::kSortGradient);
    WorkCounts* const work = tile->Work();
    work->num_rays += rays.num_rays;
    work->num_samples += tile->NumSamples();
    work->num_color_samples += tile->NumColorSamples();
    work->num_gradient_samples += num_gradient_samples;

    result.num_samples = tile->NumSamples();
    for (int axis = 0; axis < 3; ++axis) {
      std::copy(tile->Position(axis),
                tile->Position(axis) + result.num_samples,
                result.position[axis].data());
    }
    tile->CopyRawDensity(result.raw_density.data());
    clock->Stop(EngineStage::kObserveDensity);
  }

  void SumNetworkGradients(float* sum) const {
    for (size_t i = 0; i < num_results_; ++i) {
      DenseSumRows(results_[i]->network_gradient.data(),
                   nullptr,
                   1,
                   layout_.num_network_parameters,
                   sum);
    }
  }

  bool UpdateNetwork(const float learning_rate) {
    float* const gradient = network_gradient_.data();
    std::fill(gradient, gradient + network_gradient_.size(), 0.0f);
    SumNetworkGradients(gradient);
    const bool is_finite = std::all_of(
        gradient, gradient + network_gradient_.size(), [](const float g) {
          return std::abs(g) < kMaxGradient;
        });
    if (!is_finite) {
      return false;
    }
    AdamStep step;
    step.learning_rate = BiasCorrectedRate(learning_rate, num_updates_);
    AdamUpdate(step,
               layout_.num_network_parameters,
               gradient,
               network_first_moment_.data(),
               network_root_second_moment_.data(),
               network_values_.data());
    network_.SetParameters(network_values_.data());
    return true;
  }

  void ObserveDensity() {
    for (size_t i = 0; i < num_results_; ++i) {
      const TileResult& result = *results_[i];
      cache_.Observe(result.position[0].data(),
                     result.position[1].data(),
                     result.position[2].data(),
                     result.raw_density.data(),
                     result.num_samples,
                     static_cast<float>(options_.sampling.cache_decay));
    }
  }

  // Positions and raw density of a chunk.
  using RefreshBuffers = std::array<AlignedBuffer<float>, 4>;

  const EngineOptions options_;
  const FieldLayout layout_;
  const RaySamplingParameters sampling_;
  ThreadPool pool_;
  FusedNetwork network_;
  FusedGrid grid_;
  DensityCache cache_;
  std::vector<float> level_weights_;  // empty = all one

  AlignedBuffer<float> network_values_;
  AlignedBuffer<float> network_gradient_;
  AlignedBuffer<float> network_first_moment_;
  AlignedBuffer<float> network_root_second_moment_;
  int num_updates_ = 0;

  // Per thread.
  std::vector<std::unique_ptr<FusedTile>> tiles_;
  std::vector<RefreshBuffers> refresh_buffers_;

  // Per tile since the last update.
  std::vector<std::unique_ptr<TileResult>> results_;
  size_t num_results_ = 0;
};

}  // namespace

std::unique_ptr<GridEngine> MakeFusedEngine(const EngineOptions& options) {
  return std::make_unique<FusedEngine>(options);
}

}  // namespace structnerf
