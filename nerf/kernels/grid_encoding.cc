#include "nerf/kernels/grid_encoding.h"

// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nerf/kernels/grid_encoding.cc"
#include <hwy/foreach_target.h>
#include <hwy/cache_control.h>
#include <hwy/highway.h>
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace structnerf {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// Samples ahead of which table entries are requested from memory.
constexpr size_t kPrefetchDistance = 4;

void Corners(const GridLevel& level,
             const float* HWY_RESTRICT x,
             const float* HWY_RESTRICT y,
             const float* HWY_RESTRICT z,
             const size_t num_samples,
             const size_t stride,
             uint32_t* HWY_RESTRICT entries,
             float* HWY_RESTRICT weights) {
  const hn::CappedTag<float, 16> d;
  const hn::RebindToSigned<decltype(d)> di;
  const hn::RebindToUnsigned<decltype(d)> du;
  using VF = hn::VFromD<decltype(d)>;
  using VU = hn::VFromD<decltype(du)>;
  const size_t lanes = hn::Lanes(d);

  // Spatial hash of Teschner et al. 2003; a factor of one for x keeps
  // neighbours in x in the same cache line.
  const VU prime_y =
      hn::Set(du, level.hashed ? 2654435761u : level.vertices[0]);
  const VU prime_z = hn::Set(
      du, level.hashed ? 805459861u : level.vertices[0] * level.vertices[1]);
  const VU hash_mask = hn::Set(du, level.num_entries - 1);
  const VF cells_per_unit = hn::Set(d, level.cells_per_unit);
  const float* const coordinates[3] = {x, y, z};

  for (size_t s = 0; s < num_samples; s += lanes) {
    VU cell[3];
    VF upper_weight[3];
    VF lower_weight[3];
    for (int axis = 0; axis < 3; ++axis) {
      const VF last_cell =
          hn::Set(d, static_cast<float>(level.vertices[axis] - 2));
      VF position =
          hn::Mul(hn::LoadU(d, coordinates[axis] + s), cells_per_unit);
      position = hn::Min(hn::Max(position, hn::Zero(d)), last_cell);
      const auto index = hn::ConvertTo(di, position);
      cell[axis] = hn::BitCast(du, index);
      upper_weight[axis] = hn::Sub(position, hn::ConvertTo(d, index));
      lower_weight[axis] = hn::Sub(hn::Set(d, 1.0f), upper_weight[axis]);
    }
    const VU one = hn::Set(du, 1);
    const VU term_x[2] = {cell[0], hn::Add(cell[0], one)};
    const VU term_y[2] = {hn::Mul(cell[1], prime_y),
                          hn::Mul(hn::Add(cell[1], one), prime_y)};
    const VU term_z[2] = {hn::Mul(cell[2], prime_z),
                          hn::Mul(hn::Add(cell[2], one), prime_z)};
    for (int corner = 0; corner < 8; ++corner) {
      const int bx = corner & 1;
      const int by = (corner >> 1) & 1;
      const int bz = corner >> 2;
      VU entry;
      if (level.hashed) {
        entry = hn::And(hn::Xor(term_x[bx], hn::Xor(term_y[by], term_z[bz])),
                        hash_mask);
      } else {
        entry = hn::Add(term_x[bx], hn::Add(term_y[by], term_z[bz]));
      }
      const VF weight =
          hn::Mul(bx ? upper_weight[0] : lower_weight[0],
                  hn::Mul(by ? upper_weight[1] : lower_weight[1],
                          bz ? upper_weight[2] : lower_weight[2]));
      hn::StoreU(entry, du, entries + corner * stride + s);
      hn::StoreU(weight, d, weights + corner * stride + s);
    }
  }
}

void Interpolate(const hwy::float16_t* HWY_RESTRICT table,
                 const uint32_t* HWY_RESTRICT entries,
                 const float* HWY_RESTRICT weights,
                 const size_t num_samples,
                 const size_t stride,
                 const float scale,
                 const size_t encoding_width,
                 float* HWY_RESTRICT encoding) {
  const hn::CappedTag<float, kGridFeatures> d;
  const hn::Rebind<hwy::float16_t, decltype(d)> dh;
  const size_t lanes = hn::Lanes(d);
  for (size_t s = 0; s < num_samples; ++s) {
    const size_t ahead =
        s + kPrefetchDistance < num_samples ? s + kPrefetchDistance : s;
    for (int corner = 0; corner < 8; ++corner) {
      hwy::Prefetch(table +
                    static_cast<size_t>(entries[corner * stride + ahead]) *
                        kGridFeatures);
    }
    for (size_t f = 0; f < kGridFeatures; f += lanes) {
      auto sum = hn::Zero(d);
      for (int corner = 0; corner < 8; ++corner) {
        const size_t entry = entries[corner * stride + s];
        const auto value =
            hn::PromoteTo(d, hn::LoadU(dh, table + entry * kGridFeatures + f));
        sum = hn::MulAdd(hn::Set(d, weights[corner * stride + s]), value, sum);
      }
      hn::StoreU(hn::Mul(sum, hn::Set(d, scale)),
                 d,
                 encoding + s * encoding_width + f);
    }
  }
}

void Scatter(const float* HWY_RESTRICT d_encoding,
             const uint32_t* HWY_RESTRICT entries,
             const float* HWY_RESTRICT weights,
             const size_t num_samples,
             const size_t stride,
             const float scale,
             const size_t encoding_width,
             const uint32_t entry_begin,
             const uint32_t entry_end,
             float* HWY_RESTRICT gradient,
             uint64_t* HWY_RESTRICT touched_blocks) {
  const hn::CappedTag<float, kGridFeatures> d;
  const size_t lanes = hn::Lanes(d);
  for (size_t s = 0; s < num_samples; ++s) {
    const float* const sample_gradient = d_encoding + s * encoding_width;
    const size_t ahead =
        s + kPrefetchDistance < num_samples ? s + kPrefetchDistance : s;
    for (int corner = 0; corner < 8; ++corner) {
      const size_t entry = entries[corner * stride + ahead];
      hwy::Prefetch(gradient + entry * kGridFeatures);
    }
    for (int corner = 0; corner < 8; ++corner) {
      const uint32_t entry = entries[corner * stride + s];
      if (entry < entry_begin || entry >= entry_end) {
        continue;
      }
      touched_blocks[entry >> 9] |= uint64_t{1} << ((entry >> 3) & 63);
      const auto weight = hn::Set(d, scale * weights[corner * stride + s]);
      float* const target =
          gradient + static_cast<size_t>(entry) * kGridFeatures;
      for (size_t f = 0; f < kGridFeatures; f += lanes) {
        const auto sum = hn::MulAdd(weight,
                                    hn::LoadU(d, sample_gradient + f),
                                    hn::LoadU(d, target + f));
        hn::StoreU(sum, d, target + f);
      }
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace structnerf
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace structnerf {

HWY_EXPORT(Corners);
HWY_EXPORT(Interpolate);
HWY_EXPORT(Scatter);

void GridCorners(const GridLevel& level,
                 const float* x,
                 const float* y,
                 const float* z,
                 const size_t num_samples,
                 const size_t stride,
                 uint32_t* entries,
                 float* weights) {
  HWY_DYNAMIC_DISPATCH(Corners)
  (level, x, y, z, num_samples, stride, entries, weights);
}

void GridInterpolate(const hwy::float16_t* table,
                     const uint32_t* entries,
                     const float* weights,
                     const size_t num_samples,
                     const size_t stride,
                     const float scale,
                     const size_t encoding_width,
                     float* encoding) {
  HWY_DYNAMIC_DISPATCH(Interpolate)
  (table,
   entries,
   weights,
   num_samples,
   stride,
   scale,
   encoding_width,
   encoding);
}

void GridScatter(const float* d_encoding,
                 const uint32_t* entries,
                 const float* weights,
                 const size_t num_samples,
                 const size_t stride,
                 const float scale,
                 const size_t encoding_width,
                 const uint32_t entry_begin,
                 const uint32_t entry_end,
                 float* gradient,
                 uint64_t* touched_blocks) {
  HWY_DYNAMIC_DISPATCH(Scatter)
  (d_encoding,
   entries,
   weights,
   num_samples,
   stride,
   scale,
   encoding_width,
   entry_begin,
   entry_end,
   gradient,
   touched_blocks);
}

}  // namespace structnerf
#endif  // HWY_ONCE
