#include "nerf/kernels/ray_sampling.h"

#include <algorithm>
#include <cmath>

// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nerf/kernels/ray_sampling.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
#include <hwy/contrib/math/math-inl.h>
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace structnerf {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// Room for whole vectors past the last bin.
constexpr size_t kBinCapacity = kMaxRayBins + 17;

// z-depths of the bin edges and optical thickness of the bins of one ray.
HWY_INLINE void MarchRay(const RayTile& rays,
                         const int ray,
                         const DensityCache& cache,
                         const size_t num_bins,
                         float* HWY_RESTRICT bin_edges,
                         float* HWY_RESTRICT tau) {
  const hn::CappedTag<float, 16> d;
  const hn::RebindToSigned<decltype(d)> di;
  const size_t lanes = hn::Lanes(d);
  using V = hn::VFromD<decltype(d)>;

  const float log_near = std::log(rays.near[ray]);
  const float log_step =
      (std::log(rays.far[ray]) - log_near) / static_cast<float>(num_bins);
  const V ratio = hn::Set(d, std::exp(log_step));
  const V middle = hn::Mul(hn::Set(d, 0.5f), hn::Add(hn::Set(d, 1.0f), ratio));
  const V ray_length = hn::Set(d, rays.direction_norm[ray]);
  const V cells_per_unit = hn::Set(d, cache.CellsPerUnit());
  const int* const dimensions = cache.Dimensions();
  const int strides[3] = {1, dimensions[0], dimensions[0] * dimensions[1]};

  for (size_t b = 0; b < num_bins; b += lanes) {
    const V index =
        hn::Add(hn::Iota(d, 0.0f), hn::Set(d, static_cast<float>(b)));
    const V begin = hn::Exp(
        d, hn::MulAdd(index, hn::Set(d, log_step), hn::Set(d, log_near)));
    const V z = hn::Mul(begin, middle);
    auto cell = hn::Zero(di);
    for (int axis = 0; axis < 3; ++axis) {
      const V position =
          hn::Mul(hn::MulAdd(z,
                             hn::Set(d, rays.direction[axis][ray]),
                             hn::Set(d, rays.origin[axis][ray])),
                  cells_per_unit);
      const V clamped =
          hn::Min(hn::Max(position, hn::Zero(d)),
                  hn::Set(d, static_cast<float>(dimensions[axis]) - 0.5f));
      cell = hn::Add(
          cell,
          hn::Mul(hn::ConvertTo(di, clamped), hn::Set(di, strides[axis])));
    }
    const auto bytes =
        hn::GatherOffset(di, reinterpret_cast<const int*>(cache.Data()), cell);
    const V level = hn::ConvertTo(d, hn::And(bytes, hn::Set(di, 0xff)));
    const V log_density =
        hn::MulAdd(level,
                   hn::Set(d, 1.0f / DensityCache::kLevelsPerUnit),
                   hn::Set(d, DensityCache::kMinLogDensity));
    const V length = hn::Mul(hn::MulSub(begin, ratio, begin), ray_length);
    hn::StoreU(begin, d, bin_edges + b);
    hn::StoreU(hn::Mul(hn::Exp(d, log_density), length), d, tau + b);
  }
  bin_edges[0] = rays.near[ray];
  bin_edges[num_bins] = rays.far[ray];
}

// Share of the samples up to each bin edge: cdf[0] = 0, cdf[num_bins] = 1.
HWY_INLINE void Accumulate(const float* HWY_RESTRICT tau,
                           const size_t num_bins,
                           const float uniform_share,
                           float* HWY_RESTRICT cdf) {
  const hn::CappedTag<float, 16> d;
  const size_t lanes = hn::Lanes(d);
  float sum = 0;
  for (size_t b = 0; b <= num_bins; ++b) {
    cdf[b] = -sum;
    sum += tau[b];
  }
  const auto one = hn::Set(d, 1.0f);
  for (size_t b = 0; b <= num_bins; b += lanes) {
    hn::StoreU(hn::Sub(one, hn::Exp(d, hn::LoadU(d, cdf + b))), d, cdf + b);
  }
  const float absorbed = cdf[num_bins];
  const float scale =
      absorbed > 1e-6f ? (1.0f - uniform_share) / absorbed : 0.0f;
  const float uniform =
      (absorbed > 1e-6f ? uniform_share : 1.0f) / static_cast<float>(num_bins);
  for (size_t b = 0; b <= num_bins; b += lanes) {
    const auto index =
        hn::Add(hn::Iota(d, 0.0f), hn::Set(d, static_cast<float>(b)));
    hn::StoreU(hn::MulAdd(hn::LoadU(d, cdf + b),
                          hn::Set(d, scale),
                          hn::Mul(index, hn::Set(d, uniform))),
               d,
               cdf + b);
  }
  cdf[num_bins] = 1.0f;
}

void ChooseIntervalsImpl(const RayTile& rays,
                         const DensityCache& cache,
                         const RaySamplingParameters& parameters,
                         const float* jitter,
                         float* edges) {
  float bin_edges[kBinCapacity];
  float tau[kBinCapacity];
  float cdf[kBinCapacity + 16];
  const size_t num_bins = parameters.num_bins;
  const int num_samples = parameters.num_samples;
  for (int ray = 0; ray < rays.num_rays; ++ray) {
    MarchRay(rays, ray, cache, num_bins, bin_edges, tau);
    tau[num_bins] = 0;
    Accumulate(tau, num_bins, parameters.uniform_share, cdf);

    float* const ray_edges = edges + ray * (num_samples + 1);
    ray_edges[0] = rays.near[ray];
    ray_edges[num_samples] = rays.far[ray];
    const float inverse = 1.0f / static_cast<float>(num_samples - 1);
    size_t b = 0;
    for (int k = 1; k < num_samples; ++k) {
      const float target = (static_cast<float>(k - 1) + jitter[ray]) * inverse;
      while (b + 1 < num_bins && cdf[b + 1] <= target) {
        ++b;
      }
      const float width = std::max(cdf[b + 1] - cdf[b], 1e-9f);
      const float share =
          std::min(std::max((target - cdf[b]) / width, 0.0f), 1.0f);
      const float edge =
          bin_edges[b] + share * (bin_edges[b + 1] - bin_edges[b]);
      ray_edges[k] = std::min(std::max(edge, ray_edges[k - 1]), rays.far[ray]);
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace structnerf
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace structnerf {

HWY_EXPORT(ChooseIntervalsImpl);

void ChooseIntervals(const RayTile& rays,
                     const DensityCache& cache,
                     const RaySamplingParameters& parameters,
                     const float* jitter,
                     float* edges) {
  HWY_DYNAMIC_DISPATCH(ChooseIntervalsImpl)
  (rays, cache, parameters, jitter, edges);
}

}  // namespace structnerf
#endif  // HWY_ONCE
