// The oracle's own gradient, by autograd, against central differences of its
// output in double precision.

#include "nerf/engine/torch_field.h"

#include "nerf/engine/torch_compositing.h"
#include "tests/nerf/engine/random_scene.h"

#include <cmath>

#include <gtest/gtest.h>
#include <torch/torch.h>

namespace structnerf {
namespace {

constexpr int64_t kNumRays = 3;
constexpr int64_t kNumSamples = 4;

torch::Tensor ToDouble(const std::vector<float>& values) {
  return torch::tensor(values).to(torch::kDouble);
}

// A tiny field and a loss that uses everything that is rendered.
class TorchFieldTest : public testing::Test {
 protected:
  TorchFieldTest() : layout_(MakeFieldOptions(), Eigen::Vector3f::Ones()) {
    torch::manual_seed(1);
    const FieldParameters parameters =
        RandomParameters(layout_, 1.0f, 3.0f, /*seed=*/1);
    grid_ = ToDouble(parameters.grid).view({-1, kGridFeatures});
    network_ = ToDouble(parameters.network);
    grid_.requires_grad_(true);
    network_.requires_grad_(true);
    const auto options = torch::dtype(torch::kDouble);
    positions_ = torch::rand({kNumRays * kNumSamples, 3}, options);
    direction_ =
        torch::rand({kNumRays * kNumSamples, kDirectionWidth}, options);
    edges_ = 0.1 + torch::rand({kNumRays, kNumSamples + 1}, options).cumsum(1);
    ray_length_ = 1 + torch::rand({kNumRays}, options);
    weights_ = torch::rand({kNumRays, 6}, options) - 0.5;
  }

  static FieldOptions MakeFieldOptions() {
    FieldOptions options;
    options.num_levels = 2;
    options.log2_table_size = 5;
    options.min_resolution = 2;
    options.max_resolution = 5;
    options.hidden_width = 16;
    return options;
  }

  torch::Tensor Loss() const {
    const torch::Tensor encoding =
        TorchEncode(layout_, grid_, positions_, {1.0f, 0.5f});
    const torch::Tensor geometry = TorchGeometry(layout_, network_, encoding);
    const TorchComposite composite =
        CompositeWithTorch(geometry.select(1, 0).view({kNumRays, kNumSamples}),
                           edges_,
                           ray_length_);
    const torch::Tensor color =
        RayColorWithTorch(composite.weight,
                          TorchColor(layout_, network_, geometry, direction_)
                              .view({kNumRays, kNumSamples, 3}),
                          /*min_color_weight=*/0.0);
    const torch::Tensor pull = PullWithTorch(
        composite, weights_.select(1, 5).abs(), torch::ones({kNumRays}));
    return (weights_.narrow(1, 0, 3) * color).sum() +
           (weights_.select(1, 3) * composite.depth).sum() +
           (weights_.select(1, 4) * composite.opacity).sum() + pull.sum();
  }

  // Largest difference between autograd and central differences.
  double GradientError(torch::Tensor parameters) const {
    const torch::Tensor gradient =
        torch::autograd::grad({Loss()}, {parameters})[0].flatten().clone();
    const torch::NoGradGuard no_grad;
    torch::Tensor flat = parameters.view({-1});
    double largest = 0;
    for (int64_t i = 0; i < flat.numel(); ++i) {
      constexpr double kStep = 1e-6;
      const double center = flat[i].item<double>();
      flat[i] = center + kStep;
      const double above = Loss().item<double>();
      flat[i] = center - kStep;
      const double below = Loss().item<double>();
      flat[i] = center;
      largest = std::max(
          largest,
          std::abs((above - below) / (2 * kStep) - gradient[i].item<double>()));
    }
    EXPECT_GT(gradient.abs().max().item<double>(), 1e-3);
    return largest;
  }

  const FieldLayout layout_;
  torch::Tensor grid_;
  torch::Tensor network_;
  torch::Tensor positions_;
  torch::Tensor direction_;
  torch::Tensor edges_;
  torch::Tensor ray_length_;
  torch::Tensor weights_;
};

TEST_F(TorchFieldTest, GridGradient) { EXPECT_LT(GradientError(grid_), 1e-7); }

TEST_F(TorchFieldTest, NetworkGradient) {
  EXPECT_LT(GradientError(network_), 1e-7);
}

}  // namespace
}  // namespace structnerf
