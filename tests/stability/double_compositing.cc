#include "tests/stability/double_compositing.h"

#include <algorithm>
#include <cmath>

namespace structnerf {
namespace {

CompositeSamples Samples(CompositeResult* result) {
  return {result->tau.data(),
          result->transmittance.data(),
          result->weight.data(),
          result->z.data()};
}

// f(tau) = 1 / tau - 1 / (exp(tau) - 1)
double WithinInterval(const double tau) {
  return tau < 1e-4 ? 0.5 - tau / 12 : 1 / tau - 1 / std::expm1(tau);
}

}  // namespace

CompositeRays::CompositeRays(const size_t num_rays, const size_t num_samples)
    : num_rays(num_rays),
      num_samples(num_samples),
      raw_density(num_rays * num_samples),
      edges(num_rays * (num_samples + 1)),
      ray_length(num_rays, 1.0f) {}

CompositeInputs CompositeRays::Inputs() const {
  CompositeInputs inputs;
  inputs.num_rays = num_rays;
  inputs.num_samples = num_samples;
  inputs.raw_density = raw_density.data();
  inputs.edges = edges.data();
  inputs.ray_length = ray_length.data();
  return inputs;
}

CompositeResult Composite(const CompositeRays& rays) {
  CompositeResult result;
  for (std::vector<float>* values :
       {&result.tau, &result.transmittance, &result.weight, &result.z}) {
    values->resize(rays.num_rays * rays.num_samples);
  }
  for (std::vector<float>* values :
       {&result.depth, &result.depth_variance, &result.opacity}) {
    values->resize(rays.num_rays);
  }
  CompositeForward(rays.Inputs(),
                   Samples(&result),
                   result.depth.data(),
                   result.depth_variance.data(),
                   result.opacity.data());
  return result;
}

std::vector<float> CompositeGradient(const CompositeRays& rays,
                                     CompositeResult result,
                                     const float d_depth,
                                     const float pull,
                                     const float pull_z) {
  const std::vector<float> d_depths(rays.num_rays, d_depth);
  const std::vector<float> zeros(rays.num_rays * rays.num_samples, 0.0f);
  const std::vector<float> pulls(rays.num_rays, pull);
  const std::vector<float> pull_zs(rays.num_rays, pull_z);
  CompositeGradients gradients;
  gradients.depth = result.depth.data();
  gradients.d_depth = d_depths.data();
  gradients.d_opacity = zeros.data();
  gradients.pull = pulls.data();
  gradients.pull_z = pull_zs.data();
  gradients.d_weight_color = zeros.data();
  std::vector<float> d_raw_density(zeros.size());
  CompositeBackward(
      rays.Inputs(), Samples(&result), gradients, d_raw_density.data());
  return d_raw_density;
}

DoubleRay CompositeInDouble(const CompositeRays& rays, const size_t ray) {
  const size_t n = rays.num_samples;
  const float* const edges = rays.edges.data() + ray * (n + 1);
  DoubleRay result;
  double sum_tau = 0;
  for (size_t i = 0; i < n; ++i) {
    const double begin = edges[i];
    const double length = edges[i + 1] - begin;
    const double raw = std::min<double>(
        std::max<double>(rays.raw_density[ray * n + i], kMinRawDensity),
        kMaxRawDensity);
    const double tau = std::exp(raw) * length * rays.ray_length[ray];
    const bool is_last = i + 1 == n;
    const double weight =
        std::exp(-sum_tau) * (is_last ? 1.0 : -std::expm1(-tau));
    result.weight.push_back(weight);
    result.z.push_back(begin + length * (is_last ? 0.5 : WithinInterval(tau)));
    result.depth += weight * result.z.back();
    sum_tau += tau;
  }
  return result;
}

double CompositeLossInDouble(const CompositeRays& rays,
                             const size_t ray,
                             const double d_depth,
                             const double pull,
                             const double pull_z) {
  const DoubleRay composite = CompositeInDouble(rays, ray);
  double loss = d_depth * composite.depth;
  for (size_t i = 0; i < rays.num_samples; ++i) {
    loss += pull * composite.weight[i] *
            std::pow((composite.z[i] - pull_z) / pull_z, 2);
  }
  return loss;
}

}  // namespace structnerf
