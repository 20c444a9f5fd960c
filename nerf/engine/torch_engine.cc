#include "nerf/engine/torch_engine.h"

#include "nerf/engine/tile_sampling.h"
#include "nerf/engine/torch_field.h"
#include "nerf/engine/torch_rendering.h"
#include "nerf/kernels/adam.h"

#include <algorithm>
#include <cmath>

#include <torch/torch.h>

namespace structnerf {
namespace {

// Rays rendered at a time without gradients.
constexpr size_t kRenderTiles = 64;

// Samples of the rays of several tiles, one after the other.
struct SampleBatch {
  int64_t num_rays = 0;
  std::vector<float> edges;         // rays x (n + 1)
  std::vector<float> positions[3];  // rays x n
  std::vector<float> direction;     // rays x kDirectionWidth
  std::vector<float> ray_length;    // rays
};

void AppendTile(const RayTile& rays,
                const DensityCache& cache,
                const RaySamplingParameters& sampling,
                const int num_harmonics,
                Random* random,
                SampleBatch* batch) {
  const size_t n = sampling.num_samples;
  const size_t first_ray = batch->num_rays;
  batch->num_rays += rays.num_rays;
  batch->edges.resize(batch->num_rays * (n + 1));
  for (std::vector<float>& position : batch->positions) {
    position.resize(batch->num_rays * n);
  }
  batch->direction.resize(batch->num_rays * kDirectionWidth);
  SampleTile(rays,
             cache,
             sampling,
             random,
             batch->edges.data() + first_ray * (n + 1),
             batch->positions[0].data() + first_ray * n,
             batch->positions[1].data() + first_ray * n,
             batch->positions[2].data() + first_ray * n);
  for (int ray = 0; ray < rays.num_rays; ++ray) {
    EncodeDirection(
        rays,
        ray,
        num_harmonics,
        batch->direction.data() + (first_ray + ray) * kDirectionWidth);
    batch->ray_length.push_back(rays.direction_norm[ray]);
  }
}

class TorchEngine : public GridEngine {
 public:
  TorchEngine(const EngineOptions& options, const TorchPrecision precision)
      : options_(options),
        layout_(options.field, options.extent),
        type_(precision == TorchPrecision::kDouble ? torch::kDouble
                                                   : torch::kFloat),
        sampling_(MakeSamplingParameters(options.sampling)),
        cache_(MakeCache(options)) {
    SetParameters(
        InitialParameters(layout_, options.initial_density, options.seed));
    for (Moments* moments : {&grid_moments_, &network_moments_}) {
      const torch::Tensor& values =
          moments == &grid_moments_ ? grid_ : network_;
      moments->first = torch::zeros_like(values);
      moments->second = torch::zeros_like(values);
    }
  }

  const FieldLayout& Layout() const override { return layout_; }

  const DensityCache& Cache() const override { return cache_; }

  // The threads are inside of the tensor operations.
  int NumThreads() const override { return 1; }

  LossValues Accumulate(
      const StepParameters& step,
      const std::vector<std::unique_ptr<TileObjective>>& objectives) override {
    TileObjective& objective = *objectives.front();
    level_weights_ = step.level_weights;
    SampleBatch batch;
    std::vector<int> num_tile_rays;
    for (int tile = 0; tile < step.num_tiles; ++tile) {
      RayTile rays;
      objective.DrawRays(step.step, tile, &rays);
      Random random(options_.seed, step.step, tile);
      AppendTile(
          rays, cache_, sampling_, layout_.num_harmonics, &random, &batch);
      num_tile_rays.push_back(rays.num_rays);
    }
    if (batch.num_rays == 0) {
      return LossValues{};
    }
    const RenderedBatch rendered = RenderBatch(batch, /*with_color=*/true);
    const std::vector<float> density = CopyValues(rendered.raw_density);
    cache_.Observe(batch.positions[0].data(),
                   batch.positions[1].data(),
                   batch.positions[2].data(),
                   density.data(),
                   density.size(),
                   static_cast<float>(options_.sampling.cache_decay));

    // An objective judges the rays it drew last, so they are drawn again.
    LossValues losses = {};
    OutputGradients gradients;
    const std::vector<float> weight = CopyValues(rendered.composite.weight);
    std::vector<float> d_weight(weight.size(), 0.0f);
    const int64_t n = sampling_.num_samples;
    int64_t first_ray = 0;
    for (int tile = 0; tile < step.num_tiles; ++tile) {
      RayTile rays;
      objective.DrawRays(step.step, tile, &rays);
      RayOutputs outputs;
      CopyOutputs(rendered, first_ray, rays.num_rays, &outputs);
      RayGradients tile_gradients;
      AddLosses(objective.Evaluate(outputs, &tile_gradients), &losses);
      if (objective.UsesSamples()) {
        const RaySamples samples = {sampling_.num_samples,
                                    batch.edges.data() + first_ray * (n + 1),
                                    weight.data() + first_ray * n};
        AddLosses(
            objective.EvaluateSamples(samples, d_weight.data() + first_ray * n),
            &losses);
      }
      gradients.Append(tile_gradients, rays.num_rays);
      first_ray += rays.num_rays;
    }
    (gradients.Surrogate(rendered) +
     (MakeTensor(d_weight) * rendered.composite.weight.flatten()).sum())
        .backward();
    return losses;
  }

  bool Update(const float grid_learning_rate,
              const float network_learning_rate) override {
    const torch::NoGradGuard no_grad;
    ++num_updates_;
    const AdamStep step;
    const double epsilon2 = std::pow(step.epsilon, 2);
    bool all_finite = true;
    if (grid_.grad().defined()) {
      const torch::Tensor gradient = grid_.grad();
      const torch::Tensor touched = (gradient != 0).any(1);
      const torch::Tensor finite = IsFiniteGradient(gradient).all(1);
      all_finite &= finite.all().item<bool>();
      const torch::Tensor rows = (touched & finite).nonzero().squeeze(1);
      const torch::Tensor g = gradient.index_select(0, rows);
      const torch::Tensor m =
          step.beta1 * grid_moments_.first.index_select(0, rows) +
          (1 - step.beta1) * g;
      const torch::Tensor v =
          step.beta2 * grid_moments_.second.index_select(0, rows) +
          (1 - step.beta2) * g * g;
      grid_moments_.first.index_copy_(0, rows, m);
      grid_moments_.second.index_copy_(0, rows, v);
      grid_.index_add_(0, rows, m / (v + epsilon2).sqrt(), -grid_learning_rate);
      grid_.mutable_grad().zero_();
    }
    if (network_.grad().defined()) {
      const torch::Tensor g = network_.grad();
      if (IsFiniteGradient(g).all().item<bool>()) {
        Moments& moments = network_moments_;
        moments.first.mul_(step.beta1).add_(g, 1 - step.beta1);
        moments.second.mul_(step.beta2).add_(g * g, 1 - step.beta2);
        const double learning_rate =
            network_learning_rate *
            std::sqrt(1 - std::pow(step.beta2, num_updates_)) /
            (1 - std::pow(step.beta1, num_updates_));
        network_.sub_(moments.first / (moments.second + epsilon2).sqrt(),
                      learning_rate);
      } else {
        all_finite = false;
      }
      network_.mutable_grad().zero_();
    }
    return all_finite;
  }

  void RefreshDensityCache(const float decay) override {
    const torch::NoGradGuard no_grad;
    const size_t count =
        std::min(DensityCache::kRefreshCells, cache_.NumCells());
    const size_t first_visit = cache_.NextVisits(count);
    std::vector<float> positions[3];
    for (std::vector<float>& position : positions) {
      position.resize(count);
    }
    cache_.VisitPoints(first_visit,
                       count,
                       positions[0].data(),
                       positions[1].data(),
                       positions[2].data());
    const torch::Tensor geometry = TorchGeometry(
        layout_,
        network_,
        TorchEncode(layout_, grid_, StackPositions(positions), level_weights_));
    const std::vector<float> density = CopyValues(geometry.select(1, 0));
    cache_.Update(first_visit, density.data(), count, decay);
  }

  void Render(const std::vector<RayTile>& tiles,
              const bool with_color,
              std::vector<RayOutputs>* outputs) override {
    const torch::NoGradGuard no_grad;
    outputs->resize(tiles.size());
    for (size_t begin = 0; begin < tiles.size(); begin += kRenderTiles) {
      const size_t end = std::min(tiles.size(), begin + kRenderTiles);
      SampleBatch batch;
      for (size_t tile = begin; tile < end; ++tile) {
        AppendTile(tiles[tile],
                   cache_,
                   sampling_,
                   layout_.num_harmonics,
                   nullptr,
                   &batch);
      }
      if (batch.num_rays == 0) {
        continue;
      }
      const RenderedBatch rendered = RenderBatch(batch, with_color);
      int64_t first_ray = 0;
      for (size_t tile = begin; tile < end; ++tile) {
        CopyOutputs(
            rendered, first_ray, tiles[tile].num_rays, &(*outputs)[tile]);
        first_ray += tiles[tile].num_rays;
      }
    }
  }

  FieldParameters Parameters() const override {
    FieldParameters parameters = MasterParameters();
    ApplyLevelWeights(layout_, level_weights_, &parameters.grid);
    return parameters;
  }

  FieldParameters MasterParameters() const override {
    return {CopyValues(grid_), CopyValues(network_)};
  }

  void SetParameters(const FieldParameters& parameters) override {
    level_weights_.clear();
    grid_ = MakeTensor(parameters.grid)
                .view({-1, kGridFeatures})
                .requires_grad_(true);
    network_ = MakeTensor(parameters.network).requires_grad_(true);
  }

  void Restore(const FieldParameters& parameters) override {
    SetParameters(parameters);
    for (Moments* moments : {&grid_moments_, &network_moments_}) {
      moments->first.zero_();
      moments->second.zero_();
    }
    num_updates_ = 0;
    cache_ = MakeCache(options_);
  }

  void Restart(const int seed) override {
    Restore(InitialParameters(layout_, options_.initial_density, seed));
  }

  void SaveState(StateWriter* writer) const override {
    SaveHead(layout_, level_weights_, num_updates_, writer);
    for (const torch::Tensor& tensor : StateTensors()) {
      writer->Write(tensor.data_ptr(), tensor.nbytes());
    }
    cache_.SaveState(writer);
  }

  void LoadState(StateReader* reader) override {
    LoadHead(layout_, reader, &level_weights_, &num_updates_);
    for (const torch::Tensor& tensor : StateTensors()) {
      reader->Read(tensor.data_ptr(), tensor.nbytes());
    }
    cache_.LoadState(reader);
  }

  FieldParameters Gradients() const override {
    const auto gradient = [](const torch::Tensor& values) {
      return CopyValues(values.grad().defined() ? values.grad()
                                                : torch::zeros_like(values));
    };
    return {gradient(grid_), gradient(network_)};
  }

 protected:
  DensityCache* MutableCache() override { return &cache_; }

 private:
  struct Moments {
    torch::Tensor first;
    torch::Tensor second;
  };

  torch::Tensor MakeTensor(const std::vector<float>& values) const {
    return structnerf::MakeTensor(values, type_);
  }

  torch::Tensor StackPositions(const std::vector<float> (&positions)[3]) const {
    return torch::stack({MakeTensor(positions[0]),
                         MakeTensor(positions[1]),
                         MakeTensor(positions[2])},
                        1);
  }

  RenderedBatch RenderBatch(const SampleBatch& batch,
                            const bool with_color) const {
    const int64_t n = sampling_.num_samples;
    const torch::Tensor geometry = TorchGeometry(
        layout_,
        network_,
        TorchEncode(
            layout_, grid_, StackPositions(batch.positions), level_weights_));
    RenderedBatch rendered;
    rendered.raw_density = geometry.select(1, 0).view({batch.num_rays, n});
    rendered.composite = CompositeWithTorch(
        rendered.raw_density,
        MakeTensor(batch.edges).view({batch.num_rays, n + 1}),
        MakeTensor(batch.ray_length));
    if (with_color) {
      const torch::Tensor direction =
          MakeTensor(batch.direction)
              .view({batch.num_rays, kDirectionWidth})
              .repeat_interleave(n, 0);
      const torch::Tensor color =
          TorchColor(layout_, network_, geometry, direction);
      rendered.color = RayColorWithTorch(rendered.composite.weight,
                                         color.view({batch.num_rays, n, 3}),
                                         options_.min_color_weight);
    }
    return rendered;
  }

  std::vector<torch::Tensor> StateTensors() const {
    return {grid_,
            network_,
            grid_moments_.first,
            grid_moments_.second,
            network_moments_.first,
            network_moments_.second};
  }

  const EngineOptions options_;
  const FieldLayout layout_;
  const torch::ScalarType type_;
  RaySamplingParameters sampling_;
  DensityCache cache_;
  std::vector<float> level_weights_;  // empty = all one

  torch::Tensor grid_;     // num_grid_entries x kGridFeatures
  torch::Tensor network_;  // num_network_parameters
  Moments grid_moments_;
  Moments network_moments_;
  int num_updates_ = 0;
};

}  // namespace

std::unique_ptr<GridEngine> MakeTorchEngine(const EngineOptions& options,
                                            const TorchPrecision precision) {
  return std::make_unique<TorchEngine>(options, precision);
}

}  // namespace structnerf
