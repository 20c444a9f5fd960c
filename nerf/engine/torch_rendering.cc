#include "nerf/engine/torch_rendering.h"

#include "nerf/kernels/adam.h"

#include <algorithm>

#include <torch/torch.h>

namespace structnerf {

torch::Tensor MakeTensor(const std::vector<float>& values,
                         const torch::ScalarType type) {
  return torch::from_blob(const_cast<float*>(values.data()),
                          {static_cast<int64_t>(values.size())},
                          torch::kFloat)
      .to(type, /*non_blocking=*/false, /*copy=*/true);
}

std::vector<float> CopyValues(const torch::Tensor& values) {
  const torch::Tensor flat =
      values.detach().to(torch::kFloat).contiguous().flatten();
  const float* const data = flat.data_ptr<float>();
  return std::vector<float>(data, data + flat.numel());
}

torch::Tensor IsFiniteGradient(const torch::Tensor& gradient) {
  return gradient.abs() < kMaxGradient;
}

void CopyOutputs(const RenderedBatch& rendered,
                 const int64_t first_ray,
                 const int64_t num_rays,
                 RayOutputs* outputs) {
  const auto copy = [&](const torch::Tensor& from, PerRay<float>* to) {
    const std::vector<float> values =
        CopyValues(from.narrow(0, first_ray, num_rays));
    std::copy(values.begin(), values.end(), to->begin());
  };
  if (rendered.color.defined()) {
    for (int c = 0; c < 3; ++c) {
      copy(rendered.color.select(1, c), &outputs->color[c]);
    }
  }
  copy(rendered.composite.depth, &outputs->depth);
  copy(rendered.composite.variance, &outputs->depth_variance);
  copy(rendered.composite.opacity, &outputs->opacity);
}

void OutputGradients::Append(const RayGradients& gradients,
                             const int num_rays) {
  const PerRay<float>* const columns[kNumColumns] = {&gradients.d_color[0],
                                                     &gradients.d_color[1],
                                                     &gradients.d_color[2],
                                                     &gradients.d_depth,
                                                     &gradients.d_opacity,
                                                     &gradients.pull,
                                                     &gradients.pull_z};
  for (int i = 0; i < kNumColumns; ++i) {
    columns_[i].insert(
        columns_[i].end(), columns[i]->begin(), columns[i]->begin() + num_rays);
  }
}

void OutputGradients::AppendColor(const RayGradients& gradients,
                                  const int num_rays) {
  RayGradients color_gradients;
  std::copy(std::begin(gradients.d_color),
            std::end(gradients.d_color),
            std::begin(color_gradients.d_color));
  Append(color_gradients, num_rays);
}

torch::Tensor OutputGradients::Surrogate(const RenderedBatch& rendered) const {
  const auto column = [&](const int i) {
    return MakeTensor(columns_[i], rendered.raw_density.scalar_type());
  };
  torch::Tensor surrogate =
      (PullWithTorch(rendered.composite, column(5), column(6)) +
       column(3) * rendered.composite.depth +
       column(4) * rendered.composite.opacity)
          .sum();
  for (int c = 0; c < 3; ++c) {
    surrogate = surrogate + (column(c) * rendered.color.select(1, c)).sum();
  }
  return surrogate;
}

}  // namespace structnerf
