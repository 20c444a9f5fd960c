#include "nerf/engine/torch_mlp_engine.h"

#include "nerf/engine/hierarchical_sampling.h"
#include "nerf/engine/torch_mlp.h"
#include "nerf/engine/torch_rendering.h"
#include "nerf/field/mlp_layout.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <ATen/Parallel.h>
#include <torch/torch.h>

namespace structnerf {
namespace {

// Adam as NeRF uses it.
constexpr double kBeta1 = 0.9;
constexpr double kBeta2 = 0.999;
constexpr double kEpsilon = 1e-8;

// Rays of several tiles, one after the other.
struct RayBatch {
  torch::Tensor origin;      // rays x 3
  torch::Tensor direction;   // rays x 3
  torch::Tensor ray_length;  // rays, length of the direction
  torch::Tensor codes;       // rays x latent_size
  std::vector<float> near;
  std::vector<float> far;
  std::vector<float> guide_depth;  // 0 = none
  std::vector<float> guide_deviation;
};

// What both networks make of a batch.
struct MlpRendering {
  RenderedBatch coarse;
  RenderedBatch fine;        // that of the coarse network if there is no other
  std::vector<float> edges;  // of the fine points, rays x (n + 1)
  int num_points = 0;        // n
};

class TorchMlpEngine : public RenderEngine {
 public:
  TorchMlpEngine(const EngineOptions& options, const TorchPrecision precision)
      : options_(options),
        layout_(options.field),
        type_(precision == TorchPrecision::kDouble ? torch::kDouble
                                                   : torch::kFloat) {
    const Eigen::Vector3f& extent = options.extent;
    extent_ = MakeTensor({extent.x(), extent.y(), extent.z()}, type_);
    if (options.num_threads > 0) {
      at::set_num_threads(options.num_threads);
    }
    Restart(options.seed);
  }

  size_t NumParameters() const override {
    return 2 * layout_.num_parameters + static_cast<size_t>(codes_.numel());
  }

  // The threads are inside of the tensor operations.
  int NumThreads() const override { return 1; }

  LossValues Accumulate(
      const StepParameters& step,
      const std::vector<std::unique_ptr<TileObjective>>& objectives) override {
    LossValues losses = {};
    const int tiles_per_batch =
        static_cast<int>(MlpBatchSize(options_.sampling).num_tiles);
    for (int begin = 0; begin < step.num_tiles; begin += tiles_per_batch) {
      AccumulateTiles(step.step,
                      begin,
                      std::min(begin + tiles_per_batch, step.num_tiles),
                      objectives.front().get(),
                      &losses);
    }
    return losses;
  }

  bool Update(float /*grid_learning_rate*/,
              const float network_learning_rate) override {
    const torch::NoGradGuard no_grad;
    ++num_updates_;
    const double learning_rate = network_learning_rate *
                                 std::sqrt(1 - std::pow(kBeta2, num_updates_)) /
                                 (1 - std::pow(kBeta1, num_updates_));
    const std::vector<torch::Tensor> leaves = Leaves();
    const bool is_finite = std::all_of(
        leaves.begin(), leaves.end(), [](const torch::Tensor& leaf) {
          return !leaf.grad().defined() ||
                 IsFiniteGradient(leaf.grad()).all().item<bool>();
        });
    for (size_t i = 0; i < leaves.size(); ++i) {
      torch::Tensor leaf = leaves[i];
      if (!leaf.grad().defined()) {
        continue;
      }
      if (is_finite) {
        Moments& moments = moments_[i];
        moments.first.mul_(kBeta1).add_(leaf.grad(), 1 - kBeta1);
        moments.second.mul_(kBeta2).addcmul_(
            leaf.grad(), leaf.grad(), 1 - kBeta2);
        leaf.addcdiv_(moments.first,
                      moments.second.sqrt().add_(kEpsilon),
                      -learning_rate);
      }
      leaf.mutable_grad().zero_();
    }
    return is_finite;
  }

  void Render(const std::vector<RayTile>& tiles,
              const bool with_color,
              std::vector<RayOutputs>* outputs) override {
    const torch::NoGradGuard no_grad;
    outputs->resize(tiles.size());
    const size_t tiles_per_batch = MlpBatchSize(options_.sampling).num_tiles;
    const bool has_fine = options_.sampling.num_fine_samples > 0;
    for (size_t begin = 0; begin < tiles.size(); begin += tiles_per_batch) {
      const size_t end = std::min(tiles.size(), begin + tiles_per_batch);
      const std::vector<RayTile> batch(tiles.begin() + begin,
                                       tiles.begin() + end);
      const MlpRendering rendering = RenderBatch(
          MakeBatch(batch), with_color && !has_fine, with_color, nullptr);
      int64_t first_ray = 0;
      for (size_t tile = begin; tile < end; ++tile) {
        CopyOutputs(
            rendering.fine, first_ray, tiles[tile].num_rays, &(*outputs)[tile]);
        first_ray += tiles[tile].num_rays;
      }
    }
  }

  FieldParameters Parameters() const override {
    return {{}, Flatten([](const torch::Tensor& leaf) { return leaf; })};
  }

  void SetParameters(const FieldParameters& parameters) override {
    const torch::Tensor values = MakeTensor(parameters.network, type_);
    const int64_t count = static_cast<int64_t>(layout_.num_parameters);
    coarse_ = MakeTorchMlp(layout_, values.narrow(0, 0, count));
    fine_ = MakeTorchMlp(layout_, values.narrow(0, count, count));
    const int64_t num_code_values = values.size(0) - 2 * count;
    codes_ = values.narrow(0, 2 * count, num_code_values)
                 .view({-1, std::max(1, layout_.latent_size)})
                 .clone();
    for (torch::Tensor& leaf : Leaves()) {
      leaf.requires_grad_(true);
    }
  }

  FieldParameters MasterParameters() const override { return Parameters(); }

  void Restore(const FieldParameters& parameters) override {
    SetParameters(parameters);
    moments_.clear();
    for (const torch::Tensor& leaf : Leaves()) {
      moments_.push_back({torch::zeros_like(leaf), torch::zeros_like(leaf)});
    }
    num_updates_ = 0;
  }

  void Restart(const int seed) override {
    Restore({{},
             InitialMlpParameters(
                 layout_, options_.num_views, options_.initial_density, seed)});
  }

  void SaveState(StateWriter* writer) const override {
    writer->WriteValue(static_cast<uint64_t>(NumParameters()));
    writer->WriteValue(num_updates_);
    for (const torch::Tensor& tensor : StateTensors()) {
      writer->Write(tensor.data_ptr(), tensor.nbytes());
    }
  }

  void LoadState(StateReader* reader) override {
    if (reader->ReadValue<uint64_t>() != NumParameters()) {
      throw std::runtime_error("the state is that of a field of another size");
    }
    num_updates_ = reader->ReadValue<int>();
    for (const torch::Tensor& tensor : StateTensors()) {
      reader->Read(tensor.data_ptr(), tensor.nbytes());
    }
  }

  FieldParameters Gradients() const override {
    return {{}, Flatten([](const torch::Tensor& leaf) {
              return leaf.grad().defined() ? leaf.grad()
                                           : torch::zeros_like(leaf);
            })};
  }

 private:
  struct Moments {
    torch::Tensor first;
    torch::Tensor second;
  };

  // All parameters, in the order of FieldParameters::network.
  std::vector<torch::Tensor> Leaves() const {
    std::vector<torch::Tensor> leaves;
    for (const TorchMlp* mlp : {&coarse_, &fine_}) {
      for (size_t i = 0; i < mlp->weights.size(); ++i) {
        leaves.push_back(mlp->weights[i]);
        leaves.push_back(mlp->biases[i]);
      }
    }
    leaves.push_back(codes_);
    return leaves;
  }

  // Parameters and moments.
  std::vector<torch::Tensor> StateTensors() const {
    std::vector<torch::Tensor> tensors = Leaves();
    for (const Moments& moments : moments_) {
      tensors.push_back(moments.first);
      tensors.push_back(moments.second);
    }
    return tensors;
  }

  template <typename Select>
  std::vector<float> Flatten(const Select& select) const {
    std::vector<torch::Tensor> parts;
    for (const torch::Tensor& leaf : Leaves()) {
      parts.push_back(select(leaf).detach().flatten());
    }
    return CopyValues(torch::cat(parts));
  }

  RayBatch MakeBatch(const std::vector<RayTile>& tiles) const {
    RayBatch batch;
    std::vector<float> origin[3];
    std::vector<float> direction[3];
    std::vector<float> length;
    std::vector<int64_t> code_idxs[2];
    for (const RayTile& tile : tiles) {
      const auto append = [&](const PerRay<float>& from,
                              std::vector<float>* to) {
        to->insert(to->end(), from.begin(), from.begin() + tile.num_rays);
      };
      for (int axis = 0; axis < 3; ++axis) {
        append(tile.origin[axis], &origin[axis]);
        append(tile.direction[axis], &direction[axis]);
      }
      append(tile.direction_norm, &length);
      for (int i = 0; i < 2; ++i) {
        for (int ray = 0; ray < tile.num_rays; ++ray) {
          const int view_idx =
              tile.has_appearance ? tile.appearance[i][ray] : -1;
          // Behind the codes of all views is one of zeros.
          code_idxs[i].push_back(view_idx < 0 ? codes_.size(0) : view_idx);
        }
      }
      append(tile.near, &batch.near);
      append(tile.far, &batch.far);
      append(tile.is_guided ? tile.guide_depth : PerRay<float>(),
             &batch.guide_depth);
      append(tile.is_guided ? tile.guide_deviation : PerRay<float>(),
             &batch.guide_deviation);
    }
    const auto stack = [&](const std::vector<float>(&columns)[3]) {
      return torch::stack({MakeTensor(columns[0], type_),
                           MakeTensor(columns[1], type_),
                           MakeTensor(columns[2], type_)},
                          1);
    };
    batch.origin = stack(origin);
    batch.direction = stack(direction);
    batch.ray_length = MakeTensor(length, type_);
    if (layout_.latent_size > 0) {
      const torch::Tensor codes =
          torch::cat({codes_, torch::zeros({1, layout_.latent_size}, type_)});
      const auto select = [&](const std::vector<int64_t>& idxs) {
        return codes.index_select(0, torch::tensor(idxs, torch::kLong));
      };
      batch.codes = 0.5 * (select(code_idxs[0]) + select(code_idxs[1]));
    }
    return batch;
  }

  RenderedBatch RenderPoints(const TorchMlp& mlp,
                             const RayBatch& batch,
                             const std::vector<float>& edges,
                             const std::vector<float>& depths,
                             const bool with_color) const {
    const int64_t num_rays = batch.origin.size(0);
    const torch::Tensor depth = MakeTensor(depths, type_).view({num_rays, -1});
    const int64_t n = depth.size(1);
    const torch::Tensor positions =
        batch.origin.unsqueeze(1) +
        depth.unsqueeze(2) * batch.direction.unsqueeze(1);
    torch::Tensor directions;  // of the samples
    torch::Tensor codes;
    if (with_color) {
      directions = (batch.direction / batch.ray_length.unsqueeze(1))
                       .unsqueeze(1)
                       .expand({num_rays, n, 3})
                       .reshape({num_rays * n, 3});
      if (layout_.latent_size > 0) {
        codes = batch.codes.repeat_interleave(n, 0);
      }
    }
    const TorchMlpOutput output =
        EvaluateTorchMlp(layout_,
                         mlp,
                         positions.reshape({num_rays * n, 3}),
                         extent_,
                         directions,
                         codes);
    RenderedBatch rendered;
    rendered.raw_density = output.raw_density.view({num_rays, n});
    rendered.composite =
        CompositeWithTorch(rendered.raw_density,
                           MakeTensor(edges, type_).view({num_rays, n + 1}),
                           batch.ray_length);
    if (with_color) {
      rendered.color = RayColorWithTorch(rendered.composite.weight,
                                         output.color.view({num_rays, n, 3}),
                                         options_.min_color_weight);
    }
    return rendered;
  }

  // `random`: as in StratifiedPoints.
  MlpRendering RenderBatch(const RayBatch& batch,
                           const bool with_coarse_color,
                           const bool with_fine_color,
                           Random* random) const {
    const int num_coarse = options_.sampling.num_samples;
    const int num_fine = options_.sampling.num_fine_samples;
    std::vector<RayPoints> points;
    std::vector<float> depths;
    MlpRendering rendering;
    const auto append = [&](const RayPoints& of_ray) {
      rendering.edges.insert(
          rendering.edges.end(), of_ray.edges.begin(), of_ray.edges.end());
      depths.insert(depths.end(), of_ray.depth.begin(), of_ray.depth.end());
    };
    for (size_t ray = 0; ray < batch.near.size(); ++ray) {
      points.push_back(StratifiedPoints(
          batch.near[ray], batch.far[ray], num_coarse, random));
      append(points.back());
    }
    rendering.num_points = num_coarse;
    rendering.coarse = RenderPoints(
        coarse_, batch, rendering.edges, depths, with_coarse_color);
    rendering.fine = rendering.coarse;
    if (num_fine > 0) {
      const std::vector<float> weight =
          CopyValues(rendering.coarse.composite.weight);
      rendering.edges.clear();
      depths.clear();
      for (size_t ray = 0; ray < points.size(); ++ray) {
        append(RefinedPoints(points[ray],
                             weight.data() + ray * num_coarse,
                             num_fine,
                             batch.guide_depth[ray],
                             batch.guide_deviation[ray],
                             random));
      }
      rendering.num_points = num_coarse + num_fine;
      rendering.fine =
          RenderPoints(fine_, batch, rendering.edges, depths, with_fine_color);
    }
    return rendering;
  }

  void AccumulateTiles(const int step,
                       const int begin,
                       const int end,
                       TileObjective* objective,
                       LossValues* losses) {
    std::vector<RayTile> tiles(end - begin);
    size_t num_rays = 0;
    for (int tile = begin; tile < end; ++tile) {
      objective->DrawRays(step, tile, &tiles[tile - begin]);
      num_rays += tiles[tile - begin].num_rays;
    }
    if (num_rays == 0) {
      return;
    }
    Random random(options_.seed, step, begin);
    const MlpRendering rendering = RenderBatch(MakeBatch(tiles),
                                               /*with_coarse_color=*/true,
                                               /*with_fine_color=*/true,
                                               &random);
    const bool has_fine = options_.sampling.num_fine_samples > 0;
    const size_t n = rendering.num_points;
    const std::vector<float> weight =
        CopyValues(rendering.fine.composite.weight);
    std::vector<float> d_weight(weight.size(), 0.0f);
    OutputGradients coarse_gradients;
    OutputGradients fine_gradients;
    size_t first_ray = 0;
    for (int tile = begin; tile < end; ++tile) {
      // An objective judges the rays it drew last, so they are drawn again.
      RayTile rays;
      objective->DrawRays(step, tile, &rays);
      RayOutputs outputs;
      if (has_fine) {
        CopyOutputs(rendering.coarse, first_ray, rays.num_rays, &outputs);
        RayGradients gradients;
        constexpr size_t kColor = static_cast<size_t>(LossTerm::kColor);
        (*losses)[kColor] += objective->Evaluate(outputs, &gradients)[kColor];
        coarse_gradients.AppendColor(gradients, rays.num_rays);
      }
      CopyOutputs(rendering.fine, first_ray, rays.num_rays, &outputs);
      RayGradients gradients;
      AddLosses(objective->Evaluate(outputs, &gradients), losses);
      fine_gradients.Append(gradients, rays.num_rays);
      if (objective->UsesSamples()) {
        const RaySamples samples = {
            rendering.num_points,
            rendering.edges.data() + first_ray * (n + 1),
            weight.data() + first_ray * n};
        AddLosses(objective->EvaluateSamples(samples,
                                             d_weight.data() + first_ray * n),
                  losses);
      }
      first_ray += rays.num_rays;
    }
    torch::Tensor surrogate = fine_gradients.Surrogate(rendering.fine) +
                              (MakeTensor(d_weight, type_) *
                               rendering.fine.composite.weight.flatten())
                                  .sum();
    if (has_fine) {
      surrogate = surrogate + coarse_gradients.Surrogate(rendering.coarse);
    }
    surrogate.backward();
  }

  const EngineOptions options_;
  const MlpLayout layout_;
  const torch::ScalarType type_;
  torch::Tensor extent_;  // 3
  TorchMlp coarse_;
  TorchMlp fine_;
  torch::Tensor codes_;           // views x latent_size
  std::vector<Moments> moments_;  // of Leaves()
  int num_updates_ = 0;
};

}  // namespace

std::unique_ptr<RenderEngine> MakeTorchMlpEngine(
    const EngineOptions& options, const TorchPrecision precision) {
  return std::make_unique<TorchMlpEngine>(options, precision);
}

}  // namespace structnerf
