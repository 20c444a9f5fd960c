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
constexpr size_t kPrefetchDistance = 16;

using DF = hn::CappedTag<float, 16>;
using DI = hn::RebindToSigned<DF>;
using DU = hn::RebindToUnsigned<DF>;
using VF = hn::VFromD<DF>;
using VU = hn::VFromD<DU>;

// Finds the corners of vectors of points.
class CornerFinder {
 public:
  explicit CornerFinder(const GridLevel& level)
      : level_(level),
        // Spatial hash of Teschner et al. 2003; a factor of one for x keeps
        // neighbours in x in the same cache line.
        factor_y_(hn::Set(du_, level.hashed ? 2654435761u : level.vertices[0])),
        factor_z_(hn::Set(
            du_,
            level.hashed ? 805459861u : level.vertices[0] * level.vertices[1])),
        hash_mask_(hn::Set(du_, level.num_entries - 1)) {}

  // Calls put(corner, entry, weight) for the eight corners of the points from
  // x, y and z on. Bits 0, 1, 2 of `corner` tell the side in x, y and z.
  template <typename Put>
  HWY_INLINE void ForEachCorner(const float* x,
                                const float* y,
                                const float* z,
                                const Put& put) const {
    const float* const coordinates[3] = {x, y, z};
    VU cell[3];
    VF side_weight[3][2];
    for (int axis = 0; axis < 3; ++axis) {
      const VF last_cell =
          hn::Set(df_, static_cast<float>(level_.vertices[axis] - 2));
      VF position = hn::Mul(hn::LoadU(df_, coordinates[axis]),
                            hn::Set(df_, level_.cells_per_unit));
      position = hn::Min(hn::Max(position, hn::Zero(df_)), last_cell);
      const auto index = hn::ConvertTo(di_, position);
      cell[axis] = hn::BitCast(du_, index);
      side_weight[axis][1] = hn::Sub(position, hn::ConvertTo(df_, index));
      side_weight[axis][0] = hn::Sub(hn::Set(df_, 1.0f), side_weight[axis][1]);
    }
    const VU one = hn::Set(du_, 1);
    const VU term_x[2] = {cell[0], hn::Add(cell[0], one)};
    const VU term_y[2] = {hn::Mul(cell[1], factor_y_),
                          hn::Mul(hn::Add(cell[1], one), factor_y_)};
    const VU term_z[2] = {hn::Mul(cell[2], factor_z_),
                          hn::Mul(hn::Add(cell[2], one), factor_z_)};
    for (int corner = 0; corner < 8; ++corner) {
      const int side_x = corner & 1;
      const int side_y = (corner >> 1) & 1;
      const int side_z = corner >> 2;
      const VU entry =
          level_.hashed
              ? hn::And(hn::Xor(term_x[side_x],
                                hn::Xor(term_y[side_y], term_z[side_z])),
                        hash_mask_)
              : hn::Add(term_x[side_x],
                        hn::Add(term_y[side_y], term_z[side_z]));
      put(corner,
          entry,
          hn::Mul(side_weight[0][side_x],
                  hn::Mul(side_weight[1][side_y], side_weight[2][side_z])));
    }
  }

 private:
  const DF df_;
  const DI di_;
  const DU du_;
  const GridLevel& level_;
  const VU factor_y_;
  const VU factor_z_;
  const VU hash_mask_;
};

void Corners(const GridLevel& level,
             const float* HWY_RESTRICT x,
             const float* HWY_RESTRICT y,
             const float* HWY_RESTRICT z,
             const size_t num_samples,
             const size_t stride,
             uint32_t* HWY_RESTRICT entries,
             float* HWY_RESTRICT weights) {
  const DF df;
  const DU du;
  const CornerFinder finder(level);
  for (size_t s = 0; s < num_samples; s += hn::Lanes(df)) {
    finder.ForEachCorner(
        x + s,
        y + s,
        z + s,
        [&](const int corner, const VU entry, const VF weight) HWY_ATTR {
          hn::StoreU(entry, du, entries + corner * stride + s);
          hn::StoreU(weight, df, weights + corner * stride + s);
        });
  }
}

void CornerPairs(const GridLevel& level,
                 const float* HWY_RESTRICT x,
                 const float* HWY_RESTRICT y,
                 const float* HWY_RESTRICT z,
                 const size_t num_samples,
                 const size_t stride,
                 uint32_t* HWY_RESTRICT buckets,
                 CornerPair* HWY_RESTRICT pairs) {
  const DF df;
  const DU du;
  const VU entry_mask = hn::Set(du, kBucketEntries - 1);
  const CornerFinder finder(level);
  for (size_t s = 0; s < num_samples; s += hn::Lanes(df)) {
    const VU sample = hn::Iota(du, static_cast<uint32_t>(s));
    VU first_entry = hn::Zero(du);
    VF first_weight = hn::Zero(df);
    finder.ForEachCorner(
        x + s,
        y + s,
        z + s,
        [&](const int corner, const VU entry, const VF weight) HWY_ATTR {
          if (corner % 2 == 0) {
            first_entry = entry;
            first_weight = weight;
            return;
          }
          const size_t pair = corner / 2 * stride + s;
          const VU index =
              hn::Or(sample,
                     hn::Or(hn::ShiftLeft<kTileSampleBits>(
                                hn::And(first_entry, entry_mask)),
                            hn::ShiftLeft<kTileSampleBits + kBucketBits>(
                                hn::And(entry, entry_mask))));
          hn::StoreU(
              hn::Or(hn::ShiftRight<kBucketBits>(first_entry),
                     hn::ShiftLeft<16>(hn::ShiftRight<kBucketBits>(entry))),
              du,
              buckets + pair);
          hn::StoreInterleaved3(index,
                                hn::BitCast(du, first_weight),
                                hn::BitCast(du, weight),
                                du,
                                reinterpret_cast<uint32_t*>(pairs + pair));
        });
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

}  // namespace HWY_NAMESPACE
}  // namespace structnerf
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace structnerf {

HWY_EXPORT(Corners);
HWY_EXPORT(CornerPairs);
HWY_EXPORT(Interpolate);

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

void GridCornerPairs(const GridLevel& level,
                     const float* x,
                     const float* y,
                     const float* z,
                     const size_t num_samples,
                     const size_t stride,
                     uint32_t* buckets,
                     CornerPair* pairs) {
  HWY_DYNAMIC_DISPATCH(CornerPairs)
  (level, x, y, z, num_samples, stride, buckets, pairs);
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

}  // namespace structnerf
#endif  // HWY_ONCE
