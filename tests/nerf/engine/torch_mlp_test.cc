#include "nerf/engine/torch_mlp.h"

#include "nerf/util/random.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>
#include <torch/torch.h>

namespace structnerf {
namespace {

FieldOptions SmallOptions() {
  FieldOptions options;
  options.type = "mlp";
  options.mlp_num_layers = 4;
  options.mlp_width = 8;
  options.latent_size = 2;
  return options;
}

torch::Tensor Doubles(const std::vector<double>& values) {
  return torch::tensor(values, torch::kDouble);
}

// y = x W + b.
std::vector<double> Apply(const LayerLayout& layer,
                          const double* parameters,
                          const std::vector<double>& x) {
  std::vector<double> y(layer.num_outputs);
  for (int j = 0; j < layer.num_outputs; ++j) {
    y[j] = parameters[layer.biases + j];
    for (int i = 0; i < layer.num_inputs; ++i) {
      y[j] += x[i] * parameters[layer.weights + i * layer.num_outputs + j];
    }
  }
  return y;
}

void Rectify(std::vector<double>* x) {
  for (double& value : *x) {
    value = std::max(value, 0.0);
  }
}

std::vector<double> Encode(const std::vector<double>& x,
                           const int num_frequencies) {
  std::vector<double> encoding = x;
  for (int k = 0; k < num_frequencies; ++k) {
    for (const auto function : {static_cast<double (*)(double)>(std::sin),
                                static_cast<double (*)(double)>(std::cos)}) {
      for (const double value : x) {
        encoding.push_back(function(std::pow(2, k) * M_PI * value));
      }
    }
  }
  return encoding;
}

std::vector<double> Concatenate(const std::vector<double>& a,
                                const std::vector<double>& b) {
  std::vector<double> result = a;
  result.insert(result.end(), b.begin(), b.end());
  return result;
}

// A point, a direction, and parameters that make every unit count.
struct Example {
  explicit Example(const MlpLayout& layout) {
    Random random(3);
    for (size_t i = 0; i < layout.num_parameters; ++i) {
      parameters.push_back(random.NextFloat() - 0.5);
    }
    parameters[layout.density.biases] = 1;
  }

  std::vector<double> position = {0.3, 0.6, 0.45};
  std::vector<double> extent = {1, 0.8, 0.7};
  std::vector<double> direction = {0.6, 0, 0.8};
  std::vector<double> code = {0.4, -0.7};
  std::vector<double> parameters;
};

TorchMlpOutput Evaluate(const MlpLayout& layout,
                        const TorchMlp& mlp,
                        const Example& example) {
  return EvaluateTorchMlp(layout,
                          mlp,
                          Doubles(example.position).view({1, 3}),
                          Doubles(example.extent),
                          Doubles(example.direction).view({1, 3}),
                          Doubles(example.code).view({1, -1}));
}

TEST(MlpLayout, IsThatOfNerf) {
  FieldOptions options;
  options.type = "mlp";
  const MlpLayout layout(options);
  ASSERT_EQ(layout.trunk.size(), 8u);
  for (int i = 0; i < 8; ++i) {
    EXPECT_EQ(layout.trunk[i].num_inputs,
              i == 0   ? 63
              : i == 5 ? 63 + 256
                       : 256);
    EXPECT_EQ(layout.trunk[i].num_outputs, 256);
  }
  EXPECT_EQ(layout.color_hidden.num_inputs, 256 + 27);
  EXPECT_EQ(layout.color_hidden.num_outputs, 128);
  // As PyTorch counts them.
  EXPECT_EQ(layout.num_parameters, 595844u);
}

TEST(EvaluateTorchMlp, IsTheNetworkInPlainCode) {
  const MlpLayout layout(SmallOptions());
  const Example example(layout);
  const TorchMlpOutput output = Evaluate(
      layout, MakeTorchMlp(layout, Doubles(example.parameters)), example);

  std::vector<double> x;
  for (int axis = 0; axis < 3; ++axis) {
    x.push_back(2 * example.position[axis] - example.extent[axis]);
  }
  const double* const parameters = example.parameters.data();
  const std::vector<double> encoding = Encode(x, 10);
  std::vector<double> hidden = encoding;
  for (int i = 0; i < 4; ++i) {
    if (i == 3) {
      hidden = Concatenate(encoding, hidden);
    }
    hidden = Apply(layout.trunk[i], parameters, hidden);
    Rectify(&hidden);
  }
  const double density = Apply(layout.density, parameters, hidden)[0];
  ASSERT_GT(density, 0);
  EXPECT_NEAR(output.raw_density.item<double>(), std::log(2 * density), 1e-12);
  std::vector<double> color_hidden =
      Apply(layout.color_hidden,
            parameters,
            Concatenate(Concatenate(Apply(layout.feature, parameters, hidden),
                                    Encode(example.direction, 4)),
                        example.code));
  Rectify(&color_hidden);
  const std::vector<double> color =
      Apply(layout.color_output, parameters, color_hidden);
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(output.color[0][c].item<double>(),
                1 / (1 + std::exp(-color[c])),
                1e-12);
  }
}

TEST(EvaluateTorchMlp, GradientIsThatOfFiniteDifferences) {
  const MlpLayout layout(SmallOptions());
  Example example(layout);
  const auto loss_of = [&](const TorchMlp& mlp) {
    const TorchMlpOutput output = Evaluate(layout, mlp, example);
    return 0.7 * output.raw_density.sum() + output.color[0][0] -
           2 * output.color[0][1] + 3 * output.color[0][2];
  };
  TorchMlp mlp = MakeTorchMlp(layout, Doubles(example.parameters));
  for (size_t i = 0; i < mlp.weights.size(); ++i) {
    mlp.weights[i].requires_grad_(true);
    mlp.biases[i].requires_grad_(true);
  }
  loss_of(mlp).backward();
  std::vector<torch::Tensor> parts;
  for (size_t i = 0; i < mlp.weights.size(); ++i) {
    parts.push_back(mlp.weights[i].grad().flatten());
    parts.push_back(mlp.biases[i].grad());
  }
  const torch::Tensor gradient = torch::cat(parts);
  const double h = 1e-6;
  int num_nonzero = 0;
  for (size_t i = 0; i < layout.num_parameters; i += 3) {
    const auto loss_at = [&](const double offset) {
      std::vector<double> moved = example.parameters;
      moved[i] += offset;
      return loss_of(MakeTorchMlp(layout, Doubles(moved))).item<double>();
    };
    const double expected = (loss_at(h) - loss_at(-h)) / (2 * h);
    EXPECT_NEAR(
        gradient[i].item<double>(), expected, 1e-6 * (1 + std::abs(expected)))
        << i;
    num_nonzero += expected != 0;
  }
  EXPECT_GT(num_nonzero, static_cast<int>(layout.num_parameters) / 12);
}

TEST(EvaluateTorchMlp, NoDensityIsFiniteAndHasNoGradient) {
  const MlpLayout layout(SmallOptions());
  Example example(layout);
  example.parameters[layout.density.biases] = -100;
  TorchMlp mlp = MakeTorchMlp(layout, Doubles(example.parameters));
  mlp.biases[0].requires_grad_(true);
  const torch::Tensor raw_density = Evaluate(layout, mlp, example).raw_density;
  EXPECT_NEAR(raw_density.item<double>(), -12, 1e-6);
  raw_density.sum().backward();
  EXPECT_EQ(mlp.biases[0].grad().abs().max().item<double>(), 0);
}

TEST(InitialMlpParameters, SomeLightStopsAtTheStart) {
  FieldOptions options;
  options.type = "mlp";
  const MlpLayout layout(options);
  for (const uint64_t seed : {0, 1}) {
    const std::vector<float> parameters =
        InitialMlpParameters(layout, 0, 1.6f, seed);
    ASSERT_EQ(parameters.size(), 2 * layout.num_parameters);
    for (int network = 0; network < 2; ++network) {
      const torch::Tensor values = torch::tensor(std::vector<float>(
          parameters.begin() + network * layout.num_parameters,
          parameters.begin() + (network + 1) * layout.num_parameters));
      const TorchMlpOutput output =
          EvaluateTorchMlp(layout,
                           MakeTorchMlp(layout, values),
                           torch::rand({100, 3}),
                           torch::ones({3}),
                           torch::eye(3).slice(0, 0, 1).expand({100, 3}),
                           torch::Tensor());
      const double mean = output.raw_density.exp().mean().item<double>();
      EXPECT_NEAR(mean, 1.6, 0.5);
    }
  }
}

}  // namespace
}  // namespace structnerf
