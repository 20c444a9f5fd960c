#include "nerf/engine/torch_compositing.h"

#include "nerf/kernels/compositing.h"

#include <torch/torch.h>

namespace structnerf {
namespace {

// f(tau) of nerf/kernels/compositing.h.
torch::Tensor WithinInterval(const torch::Tensor& tau) {
  // Where the closed form has lost as many digits as the series is short of.
  const double series_tau = tau.scalar_type() == torch::kDouble ? 0.05 : 0.3;
  const torch::Tensor is_small = tau < series_tau;
  // Values that stand in for those of the other branch keep its derivative
  // finite.
  const torch::Tensor small =
      torch::where(is_small, tau, torch::zeros_like(tau));
  const torch::Tensor large =
      torch::where(is_small, torch::ones_like(tau), tau);
  const torch::Tensor square = small * small;
  const torch::Tensor series =
      0.5 -
      small * (1.0 / 12 -
               square * (1.0 / 720 - square * (1.0 / 30240 -
                                               square * (1.0 / 1209600 -
                                                         square / 47900160))));
  const torch::Tensor closed =
      1 / large + torch::exp(-large) / torch::expm1(-large);
  return torch::where(is_small, series, closed);
}

}  // namespace

TorchComposite CompositeWithTorch(const torch::Tensor& raw_density,
                                  const torch::Tensor& edges,
                                  const torch::Tensor& ray_length) {
  const int64_t n = raw_density.size(1);
  const torch::Tensor begin = edges.narrow(1, 0, n);
  const torch::Tensor length = edges.narrow(1, 1, n) - begin;
  const torch::Tensor tau =
      torch::exp(torch::clamp(raw_density, kMinRawDensity, kMaxRawDensity)) *
      length * ray_length.unsqueeze(1);
  // The last interval is opaque whatever its density.
  const torch::Tensor inner = tau.narrow(1, 0, n - 1);
  const torch::Tensor sums =
      torch::cat({torch::zeros_like(tau.narrow(1, 0, 1)), inner}, 1).cumsum(1);
  const torch::Tensor transmittance = torch::exp(-sums);
  const torch::Tensor last = transmittance.narrow(1, n - 1, 1);

  TorchComposite result;
  result.weight = torch::cat(
      {transmittance.narrow(1, 0, n - 1) * -torch::expm1(-inner), last}, 1);
  const torch::Tensor inner_z =
      begin.narrow(1, 0, n - 1) +
      length.narrow(1, 0, n - 1) * WithinInterval(inner);
  const torch::Tensor last_z =
      begin.narrow(1, n - 1, 1) + 0.5 * length.narrow(1, n - 1, 1);
  result.z = torch::cat({inner_z, last_z}, 1);
  result.depth = (result.weight * result.z).sum(1);
  const torch::Tensor difference = result.z - result.depth.unsqueeze(1);
  result.variance = (result.weight * difference * difference).sum(1);
  result.opacity = 1 - last.squeeze(1);
  return result;
}

torch::Tensor RayColorWithTorch(const torch::Tensor& weight,
                                const torch::Tensor& color,
                                const double min_color_weight) {
  const torch::Tensor used = weight * (weight.detach() >= min_color_weight);
  const torch::Tensor sum = (used.unsqueeze(2) * color).sum(1);
  return sum / used.sum(1, /*keepdim=*/true);
}

torch::Tensor PullWithTorch(const TorchComposite& composite,
                            const torch::Tensor& pull,
                            const torch::Tensor& pull_z) {
  const torch::Tensor target =
      torch::where(pull != 0, pull_z, torch::ones_like(pull_z)).unsqueeze(1);
  const torch::Tensor offset = (composite.z - target) / target;
  return pull * (composite.weight * offset * offset).sum(1);
}

}  // namespace structnerf
