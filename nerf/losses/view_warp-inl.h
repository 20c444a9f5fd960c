// Warping in vectors of rays or pixels. Included once per instruction set, see
// Highway's documentation of foreach_target.h.

#if defined(NERF_LOSSES_VIEW_WARP_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef NERF_LOSSES_VIEW_WARP_INL_H_
#undef NERF_LOSSES_VIEW_WARP_INL_H_
#else
#define NERF_LOSSES_VIEW_WARP_INL_H_
#endif

#include "nerf/losses/view_warp.h"

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace structnerf {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// Vector of rays or pixels. Every lane is one, so the code reads like that for
// a single one.
using D = hn::CappedTag<float, 16>;
using DI = hn::RebindToSigned<D>;
using V = hn::VFromD<D>;
using VI = hn::VFromD<DI>;
using M = decltype(hn::Eq(V(), V()));

constexpr float kInverseMaxGray = 1.0f / TrainingViews::kMaxGray;

// One warp per lane.
struct WarpVector {
  V h[9];
  V b[3];
  V width;
  V height;
  VI first_pixel;
  VI stride;
};

HWY_INLINE WarpVector GatherWarps(const ViewWarp* warps, const VI index) {
  const D d;
  const DI di;
  constexpr int kFields = sizeof(ViewWarp) / sizeof(float);
  const VI offset = hn::Mul(index, hn::Set(di, kFields));
  const float* const base = reinterpret_cast<const float*>(warps);
  const int* const integer_base = reinterpret_cast<const int*>(warps);
  WarpVector warp;
  for (int i = 0; i < 9; ++i) {
    warp.h[i] = hn::GatherIndex(d, base + i, offset);
  }
  for (int i = 0; i < 3; ++i) {
    warp.b[i] = hn::GatherIndex(d, base + 9 + i, offset);
  }
  warp.width = hn::GatherIndex(d, base + 12, offset);
  warp.height = hn::GatherIndex(d, base + 13, offset);
  warp.first_pixel = hn::GatherIndex(di, integer_base + 14, offset);
  warp.stride = hn::GatherIndex(di, integer_base + 15, offset);
  return warp;
}

// Where image point (u, v) can be interpolated: pixel centres are at halves,
// and there must be a neighbour each way.
HWY_INLINE M IsInside(const WarpVector& warp,
                      const V pixel_u,
                      const V pixel_v) {
  const D d;
  const V zero = hn::Zero(d);
  const V one = hn::Set(d, 1.0f);
  return hn::And(
      hn::And(hn::Ge(pixel_u, zero), hn::Lt(pixel_u, hn::Sub(warp.width, one))),
      hn::And(hn::Ge(pixel_v, zero),
              hn::Lt(pixel_v, hn::Sub(warp.height, one))));
}

// Grey value at pixel coordinates (u, v), the first pixel's centre at zero, by
// bilinear interpolation, and its derivatives.
HWY_INLINE V Bilinear(const uint16_t* grays,
                      const WarpVector& warp,
                      const V u,
                      const V v,
                      const M inside,
                      V* by_u,
                      V* by_v,
                      M* is_unmasked) {
  const D d;
  const DI di;
  const VI x = hn::ConvertTo(di, u);
  const VI y = hn::ConvertTo(di, v);
  const V fu = hn::Sub(u, hn::ConvertTo(d, x));
  const V fv = hn::Sub(v, hn::ConvertTo(d, y));
  const VI pixel = hn::IfThenElseZero(
      hn::RebindMask(di, inside),
      hn::Add(warp.first_pixel, hn::Add(hn::Mul(y, warp.stride), x)));
  const VI next_row = hn::IfThenElseZero(hn::RebindMask(di, inside),
                                         hn::Add(pixel, warp.stride));
  // One 32-bit read holds two neighbours in a row.
  const int* const base = reinterpret_cast<const int*>(grays);
  const VI top = hn::GatherOffset(di, base, hn::ShiftLeft<1>(pixel));
  const VI bottom = hn::GatherOffset(di, base, hn::ShiftLeft<1>(next_row));
  const VI low = hn::Set(di, 0xffff);
  const VI i00 = hn::And(top, low);
  const VI i01 = hn::And(hn::ShiftRight<16>(top), low);
  const VI i10 = hn::And(bottom, low);
  const VI i11 = hn::And(hn::ShiftRight<16>(bottom), low);
  const VI brightest = hn::Max(hn::Max(i00, i01), hn::Max(i10, i11));
  *is_unmasked = hn::RebindMask(
      d, hn::Ne(brightest, hn::Set(di, TrainingViews::kMaskedGray)));
  const V scale = hn::Set(d, kInverseMaxGray);
  const V v00 = hn::Mul(hn::ConvertTo(d, i00), scale);
  const V v01 = hn::Mul(hn::ConvertTo(d, i01), scale);
  const V v10 = hn::Mul(hn::ConvertTo(d, i10), scale);
  const V v11 = hn::Mul(hn::ConvertTo(d, i11), scale);
  const V top_slope = hn::Sub(v01, v00);
  const V bottom_slope = hn::Sub(v11, v10);
  const V top_value = hn::MulAdd(fu, top_slope, v00);
  const V bottom_value = hn::MulAdd(fu, bottom_slope, v10);
  *by_u = hn::MulAdd(fv, hn::Sub(bottom_slope, top_slope), top_slope);
  *by_v = hn::Sub(bottom_value, top_value);
  return hn::MulAdd(fv, *by_v, top_value);
}

}  // namespace HWY_NAMESPACE
}  // namespace structnerf
HWY_AFTER_NAMESPACE();

#endif  // NERF_LOSSES_VIEW_WARP_INL_H_
