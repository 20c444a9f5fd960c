#include "nerf/kernels/ray_sampling.h"

#include <algorithm>

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

// One lane per ray.
using DF = hn::CappedTag<float, 16>;
using DI = hn::RebindToSigned<DF>;
using VF = hn::VFromD<DF>;
using VI = hn::VFromD<DI>;

constexpr size_t kMaxLanes = 16;
static_assert(kMaxTileRays % kMaxLanes == 0);

// Below this, the cached light along a ray says nothing.
constexpr float kMinAbsorbed = 1e-6f;

// Numbers of a vector of rays.
struct RayVector {
  VF origin[3];
  VF direction[3];
  VF length;  // per unit of z-depth
  VF near;
  VF far;
};

// Rays [first, first + lanes); those beyond the last repeat it.
HWY_INLINE RayVector LoadRays(const RayTile& rays, const int first) {
  const DF d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const auto load = [&](const PerRay<float>& values) HWY_ATTR {
    if (first + lanes <= rays.num_rays) {
      return hn::LoadU(d, values.data() + first);
    }
    HWY_ALIGN float padded[kMaxLanes];
    for (int lane = 0; lane < lanes; ++lane) {
      padded[lane] = values[std::min(first + lane, rays.num_rays - 1)];
    }
    return hn::Load(d, padded);
  };
  RayVector result;
  for (int axis = 0; axis < 3; ++axis) {
    result.origin[axis] = load(rays.origin[axis]);
    result.direction[axis] = load(rays.direction[axis]);
  }
  result.length = load(rays.direction_norm);
  result.near = load(rays.near);
  result.far = load(rays.far);
  return result;
}

// Reads the density cache along rays.
class CacheReader {
 public:
  explicit CacheReader(const DensityCache& cache) : cache_(cache) {
    for (int axis = 0; axis < 3; ++axis) {
      last_cell_[axis] =
          hn::Set(df_, static_cast<float>(cache.Dimensions()[axis]) - 0.5f);
    }
  }

  // Density at z-depths of the rays.
  HWY_INLINE VF Density(const RayVector& rays, const VF z) const {
    VI cell[3];
    for (int axis = 0; axis < 3; ++axis) {
      const VF position =
          hn::Mul(hn::MulAdd(z, rays.direction[axis], rays.origin[axis]),
                  hn::Set(df_, cache_.CellsPerUnit()));
      cell[axis] = hn::ConvertTo(
          di_, hn::Min(hn::Max(position, hn::Zero(df_)), last_cell_[axis]));
    }
    // DensityCache::CellIndex.
    const VI block =
        hn::Add(hn::ShiftRight<2>(cell[0]),
                hn::Add(hn::Mul(hn::ShiftRight<2>(cell[1]),
                                hn::Set(di_, cache_.BlockStrides()[0])),
                        hn::Mul(hn::ShiftRight<2>(cell[2]),
                                hn::Set(di_, cache_.BlockStrides()[1]))));
    const VI three = hn::Set(di_, 3);
    const VI in_block =
        hn::Or(hn::And(cell[0], three),
               hn::Or(hn::ShiftLeft<2>(hn::And(cell[1], three)),
                      hn::ShiftLeft<4>(hn::And(cell[2], three))));
    const VI bytes =
        hn::GatherOffset(di_,
                         reinterpret_cast<const int*>(cache_.Data()),
                         hn::Or(hn::ShiftLeft<6>(block), in_block));
    const VF level = hn::ConvertTo(df_, hn::And(bytes, hn::Set(di_, 0xff)));
    return hn::Exp(df_,
                   hn::MulAdd(level,
                              hn::Set(df_, 1.0f / DensityCache::kLevelsPerUnit),
                              hn::Set(df_, DensityCache::kMinLogDensity)));
  }

 private:
  const DF df_;
  const DI di_;
  const DensityCache& cache_;
  VF last_cell_[3];
};

// Edges of a vector of rays, (num_samples + 1) x lanes.
HWY_INLINE void ChooseRayIntervals(const RayVector& rays,
                                   const CacheReader& reader,
                                   const RaySamplingParameters& parameters,
                                   const VF jitter,
                                   float* HWY_RESTRICT edges) {
  const DF d;
  const DI di;
  const size_t lanes = hn::Lanes(d);
  const VF one = hn::Set(d, 1.0f);
  const int num_bins = parameters.num_bins;

  // Bin b begins at near * ratio^b.
  const VF log_step = hn::Mul(hn::Log(d, hn::Div(rays.far, rays.near)),
                              hn::Set(d, 1.0f / static_cast<float>(num_bins)));
  const VF ratio = hn::Exp(d, log_step);
  const VF middle = hn::Mul(hn::Set(d, 0.5f), hn::Add(one, ratio));
  const VF length = hn::Mul(hn::Sub(ratio, one), rays.length);

  // Light absorbed up to the beginning of each bin, (num_bins + 1) x lanes.
  HWY_ALIGN float cdf[(kMaxRayBins + 1) * kMaxLanes];
  VF begin = rays.near;
  VF tau = hn::Zero(d);
  hn::Store(tau, d, cdf);
  for (int b = 0; b < num_bins; ++b) {
    const VF density = reader.Density(rays, hn::Mul(begin, middle));
    tau = hn::MulAdd(density, hn::Mul(begin, length), tau);
    hn::Store(hn::Sub(one, hn::Exp(d, hn::Neg(tau))), d, cdf + (b + 1) * lanes);
    begin = hn::Mul(begin, ratio);
  }

  // From it, the share of the samples.
  const VF absorbed = hn::Load(d, cdf + num_bins * lanes);
  const auto is_known = hn::Gt(absorbed, hn::Set(d, kMinAbsorbed));
  const VF uniform_share =
      hn::IfThenElse(is_known, hn::Set(d, parameters.uniform_share), one);
  const VF scale = hn::IfThenElseZero(
      is_known, hn::Div(hn::Sub(one, uniform_share), absorbed));
  const VF uniform =
      hn::Mul(uniform_share, hn::Set(d, 1.0f / static_cast<float>(num_bins)));
  for (int b = 1; b < num_bins; ++b) {
    const VF share = hn::Load(d, cdf + b * lanes);
    const VF uniform_sum = hn::Mul(uniform, hn::Set(d, static_cast<float>(b)));
    hn::Store(hn::MulAdd(share, scale, uniform_sum), d, cdf + b * lanes);
  }
  hn::Store(one, d, cdf + num_bins * lanes);

  const int num_samples = parameters.num_samples;
  const VF step = hn::Set(d, 1.0f / static_cast<float>(num_samples - 1));
  const VI lane = hn::Iota(di, 0);
  hn::Store(rays.near, d, edges);
  VF edge = rays.near;
  for (int k = 1; k < num_samples; ++k) {
    const VF target =
        hn::Mul(hn::Add(jitter, hn::Set(d, static_cast<float>(k - 1))), step);
    // The bin in which the share reaches the target.
    VF bin = hn::Zero(d);
    for (int b = 1; b < num_bins; ++b) {
      const auto is_before = hn::Le(hn::Load(d, cdf + b * lanes), target);
      bin = hn::IfThenElse(is_before, hn::Add(bin, one), bin);
    }
    const VI index = hn::Add(
        hn::Mul(hn::ConvertTo(di, bin), hn::Set(di, static_cast<int>(lanes))),
        lane);
    const VF share_begin = hn::GatherIndex(d, cdf, index);
    const VF share_end = hn::GatherIndex(d, cdf + lanes, index);
    const VF width =
        hn::Max(hn::Sub(share_end, share_begin), hn::Set(d, 1e-9f));
    const VF inside = hn::Min(
        hn::Max(hn::Div(hn::Sub(target, share_begin), width), hn::Zero(d)),
        one);
    const VF bin_begin = hn::Mul(rays.near, hn::Exp(d, hn::Mul(bin, log_step)));
    const VF candidate =
        hn::MulAdd(hn::Mul(inside, hn::Sub(ratio, one)), bin_begin, bin_begin);
    edge = hn::Min(hn::Max(candidate, edge), rays.far);
    hn::Store(edge, d, edges + k * lanes);
  }
  hn::Store(rays.far, d, edges + num_samples * lanes);
}

void ChooseIntervalsImpl(const RayTile& rays,
                         const DensityCache& cache,
                         const RaySamplingParameters& parameters,
                         const PerRay<float>& jitter,
                         float* edges) {
  const DF d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const int num_edges = parameters.num_samples + 1;
  const CacheReader reader(cache);
  HWY_ALIGN float vector_edges[(kMaxRaySamples + 1) * kMaxLanes];
  for (int first = 0; first < rays.num_rays; first += lanes) {
    ChooseRayIntervals(LoadRays(rays, first),
                       reader,
                       parameters,
                       hn::LoadU(d, jitter.data() + first),
                       vector_edges);
    const int num_rays = std::min(lanes, rays.num_rays - first);
    for (int lane = 0; lane < num_rays; ++lane) {
      float* const ray_edges = edges + (first + lane) * num_edges;
      for (int k = 0; k < num_edges; ++k) {
        ray_edges[k] = vector_edges[k * lanes + lane];
      }
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
                     const PerRay<float>& jitter,
                     float* edges) {
  HWY_DYNAMIC_DISPATCH(ChooseIntervalsImpl)
  (rays, cache, parameters, jitter, edges);
}

}  // namespace structnerf
#endif  // HWY_ONCE
