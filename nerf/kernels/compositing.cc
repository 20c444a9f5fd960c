#include "nerf/kernels/compositing.h"

#include "nerf/engine/ray_tile.h"

// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nerf/kernels/compositing.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
#include <hwy/contrib/math/math-inl.h>
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace structnerf {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// Below this optical thickness the closed forms of f and f' cancel; their
// series is then exact to float precision.
constexpr float kSeriesTau = 0.3f;

// f(tau) and f'(tau), see the header.
template <class D, class V = hn::VFromD<D>>
HWY_INLINE V WithinInterval(const D d, const V tau, V* derivative) {
  const V one = hn::Set(d, 1.0f);
  const V tau2 = hn::Mul(tau, tau);
  // f = 1/2 - tau/12 + tau^3/720 - tau^5/30240 + tau^7/1209600
  V series =
      hn::MulAdd(tau2, hn::Set(d, 8.2671958e-7f), hn::Set(d, -3.3068783e-5f));
  series = hn::MulAdd(tau2, series, hn::Set(d, 1.3888889e-3f));
  series = hn::MulAdd(tau2, series, hn::Set(d, -8.3333333e-2f));
  series = hn::MulAdd(tau, series, hn::Set(d, 0.5f));
  V series_derivative =
      hn::MulAdd(tau2, hn::Set(d, 5.7870370e-6f), hn::Set(d, -1.6534392e-4f));
  series_derivative =
      hn::MulAdd(tau2, series_derivative, hn::Set(d, 4.1666667e-3f));
  series_derivative =
      hn::MulAdd(tau2, series_derivative, hn::Set(d, -8.3333333e-2f));

  const auto is_small = hn::Lt(tau, hn::Set(d, kSeriesTau));
  const V safe_tau = hn::Max(tau, hn::Set(d, kSeriesTau));
  const V inverse_tau = hn::Div(one, safe_tau);
  // u = exp(-tau), 1 / (exp(tau) - 1) = u / (1 - u).
  const V u = hn::Exp(d, hn::Neg(safe_tau));
  const V inverse = hn::Div(one, hn::Sub(one, u));
  const V closed = hn::NegMulAdd(u, inverse, inverse_tau);
  const V closed_derivative = hn::NegMulAdd(
      inverse_tau, inverse_tau, hn::Mul(u, hn::Mul(inverse, inverse)));
  *derivative = hn::IfThenElse(is_small, series_derivative, closed_derivative);
  return hn::IfThenElse(is_small, series, closed);
}

// tau of samples [0, n) of one ray, and their transmittance.
HWY_INLINE void OpticalThickness(const CompositeInputs& inputs,
                                 const size_t ray,
                                 const CompositeSamples& samples) {
  const hn::CappedTag<float, 16> d;
  const size_t lanes = hn::Lanes(d);
  const size_t n = inputs.num_samples;
  float* const tau = samples.tau + ray * n;
  float* const transmittance = samples.transmittance + ray * n;
  const float* const edges = inputs.edges + ray * (n + 1);
  const float* const raw =
      inputs.raw_density + ray * n * inputs.raw_density_stride;
  for (size_t i = 0; i < n; ++i) {
    tau[i] = raw[i * inputs.raw_density_stride];
  }
  const auto ray_length = hn::Set(d, inputs.ray_length[ray]);
  size_t i = 0;
  for (; i + lanes <= n; i += lanes) {
    const auto clamped =
        hn::Min(hn::Max(hn::LoadU(d, tau + i), hn::Set(d, kMinRawDensity)),
                hn::Set(d, kMaxRawDensity));
    const auto length =
        hn::Sub(hn::LoadU(d, edges + i + 1), hn::LoadU(d, edges + i));
    hn::StoreU(
        hn::Mul(hn::Exp(d, clamped), hn::Mul(length, ray_length)), d, tau + i);
  }
  const hn::CappedTag<float, 1> d1;
  for (; i < n; ++i) {
    const auto clamped =
        hn::Min(hn::Max(hn::LoadU(d1, tau + i), hn::Set(d1, kMinRawDensity)),
                hn::Set(d1, kMaxRawDensity));
    tau[i] = hn::GetLane(hn::Exp(d1, clamped)) * (edges[i + 1] - edges[i]) *
             inputs.ray_length[ray];
  }
  float sum = 0;
  for (i = 0; i < n; ++i) {
    transmittance[i] = -sum;
    sum += tau[i];
  }
  i = 0;
  for (; i + lanes <= n; i += lanes) {
    hn::StoreU(
        hn::Exp(d, hn::LoadU(d, transmittance + i)), d, transmittance + i);
  }
  for (; i < n; ++i) {
    transmittance[i] = hn::GetLane(hn::Exp(d1, hn::Set(d1, transmittance[i])));
  }
}

// Weights and depths of samples [i, i + lanes of d) of one ray.
template <class D>
HWY_INLINE void WeightsAndDepths(const D d,
                                 const size_t i,
                                 const float* edges,
                                 const float* tau,
                                 const float* transmittance,
                                 float* weight,
                                 float* z) {
  using V = hn::VFromD<D>;
  const V t = hn::LoadU(d, tau + i);
  const V alpha = hn::Neg(hn::Expm1(d, hn::Neg(t)));
  hn::StoreU(hn::Mul(hn::LoadU(d, transmittance + i), alpha), d, weight + i);
  const V begin = hn::LoadU(d, edges + i);
  const V length = hn::Sub(hn::LoadU(d, edges + i + 1), begin);
  V derivative;
  hn::StoreU(
      hn::MulAdd(length, WithinInterval(d, t, &derivative), begin), d, z + i);
}

void CompositeForwardImpl(const CompositeInputs& inputs,
                          const CompositeSamples& samples,
                          float* depth,
                          float* depth_variance,
                          float* opacity) {
  const hn::CappedTag<float, 16> d;
  const hn::CappedTag<float, 1> d1;
  const size_t lanes = hn::Lanes(d);
  const size_t n = inputs.num_samples;
  for (size_t ray = 0; ray < inputs.num_rays; ++ray) {
    OpticalThickness(inputs, ray, samples);
    const float* const edges = inputs.edges + ray * (n + 1);
    const float* const tau = samples.tau + ray * n;
    const float* const transmittance = samples.transmittance + ray * n;
    float* const weight = samples.weight + ray * n;
    float* const z = samples.z + ray * n;
    size_t i = 0;
    for (; i + lanes <= n; i += lanes) {
      WeightsAndDepths(d, i, edges, tau, transmittance, weight, z);
    }
    for (; i < n; ++i) {
      WeightsAndDepths(d1, i, edges, tau, transmittance, weight, z);
    }
    weight[n - 1] = transmittance[n - 1];
    z[n - 1] = 0.5f * (edges[n - 1] + edges[n]);

    float mean = 0;
    for (i = 0; i < n; ++i) {
      mean += weight[i] * z[i];
    }
    float variance = 0;
    for (i = 0; i < n; ++i) {
      const float difference = z[i] - mean;
      variance += weight[i] * difference * difference;
    }
    depth[ray] = mean;
    depth_variance[ray] = variance;
    opacity[ray] = 1.0f - transmittance[n - 1];
  }
}

HWY_INLINE void WithinIntervalDerivatives(const float* tau,
                                          const size_t n,
                                          float* derivatives) {
  const hn::CappedTag<float, 16> d;
  const hn::CappedTag<float, 1> d1;
  const size_t lanes = hn::Lanes(d);
  size_t i = 0;
  for (; i + lanes <= n; i += lanes) {
    auto derivative = hn::Zero(d);
    WithinInterval(d, hn::LoadU(d, tau + i), &derivative);
    hn::StoreU(derivative, d, derivatives + i);
  }
  for (; i < n; ++i) {
    auto derivative = hn::Zero(d1);
    WithinInterval(d1, hn::Set(d1, tau[i]), &derivative);
    derivatives[i] = hn::GetLane(derivative);
  }
}

void CompositeBackwardImpl(const CompositeInputs& inputs,
                           const CompositeSamples& samples,
                           const CompositeGradients& gradients,
                           float* d_raw_density) {
  const size_t n = inputs.num_samples;
  const size_t stride = inputs.raw_density_stride;
  float z_by_tau[kMaxRaySamples];  // f'(tau)
  for (size_t ray = 0; ray < inputs.num_rays; ++ray) {
    const float* const edges = inputs.edges + ray * (n + 1);
    const float* const tau = samples.tau + ray * n;
    const float* const transmittance = samples.transmittance + ray * n;
    const float* const weight = samples.weight + ray * n;
    const float* const z = samples.z + ray * n;
    const float* const raw = inputs.raw_density + ray * n * stride;
    const float* const d_weight_color = gradients.d_weight_color + ray * n;
    float* const d_raw = d_raw_density + ray * n;

    const float depth = gradients.depth[ray];
    const float d_depth = gradients.d_depth[ray];
    const float pull_z =
        gradients.pull[ray] != 0 ? gradients.pull_z[ray] : 1.0f;
    const float pull = gradients.pull[ray] / (pull_z * pull_z);

    WithinIntervalDerivatives(tau, n, z_by_tau);

    // Walks from the back so that the sum over later samples is never a
    // difference of large numbers.
    float later = 0;  // sum_{j > i} w_j dL/dw_j
    for (size_t k = n; k-- > 0;) {
      // Relative to a sample at the ray's depth, as d_weight_color.
      const float d_weight =
          d_weight_color[k] +
          (z[k] - depth) *
              (d_depth + pull * ((z[k] - pull_z) + (depth - pull_z)));
      if (k == n - 1) {
        later = weight[k] * (d_weight - gradients.d_opacity[ray]);
        d_raw[k] = 0;
        continue;
      }
      const float d_z = weight[k] * (d_depth + 2 * pull * (z[k] - pull_z));
      const float length = edges[k + 1] - edges[k];
      const float d_tau =
          transmittance[k + 1] * d_weight - later + d_z * length * z_by_tau[k];
      const float raw_k = raw[k * stride];
      const bool clamped = raw_k < kMinRawDensity || raw_k > kMaxRawDensity;
      d_raw[k] = clamped ? 0.0f : d_tau * tau[k];
      later += weight[k] * d_weight;
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace structnerf
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace structnerf {

HWY_EXPORT(CompositeForwardImpl);
HWY_EXPORT(CompositeBackwardImpl);

void CompositeForward(const CompositeInputs& inputs,
                      const CompositeSamples& samples,
                      float* depth,
                      float* depth_variance,
                      float* opacity) {
  HWY_DYNAMIC_DISPATCH(CompositeForwardImpl)
  (inputs, samples, depth, depth_variance, opacity);
}

void CompositeBackward(const CompositeInputs& inputs,
                       const CompositeSamples& samples,
                       const CompositeGradients& gradients,
                       float* d_raw_density) {
  HWY_DYNAMIC_DISPATCH(CompositeBackwardImpl)
  (inputs, samples, gradients, d_raw_density);
}

}  // namespace structnerf
#endif  // HWY_ONCE
