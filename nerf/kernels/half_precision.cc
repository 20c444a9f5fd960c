#include "nerf/kernels/half_precision.h"

// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nerf/kernels/half_precision.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace structnerf {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

template <class D>
HWY_INLINE void DemoteVector(const D d, const float* from, hwy::float16_t* to) {
  const hn::Rebind<hwy::float16_t, D> dh;
  hn::StoreU(hn::DemoteTo(dh, hn::LoadU(d, from)), dh, to);
}

template <class D>
HWY_INLINE void PromoteVector(const D d,
                              const hwy::float16_t* from,
                              float* to) {
  const hn::Rebind<hwy::float16_t, D> dh;
  hn::StoreU(hn::PromoteTo(d, hn::LoadU(dh, from)), d, to);
}

void Demote(const float* from, const size_t count, hwy::float16_t* to) {
  const hn::CappedTag<float, 8> d;
  const size_t lanes = hn::Lanes(d);
  size_t i = 0;
  for (; i + lanes <= count; i += lanes) {
    DemoteVector(d, from + i, to + i);
  }
  for (; i < count; ++i) {
    DemoteVector(hn::CappedTag<float, 1>(), from + i, to + i);
  }
}

void Promote(const hwy::float16_t* from, const size_t count, float* to) {
  const hn::CappedTag<float, 8> d;
  const size_t lanes = hn::Lanes(d);
  size_t i = 0;
  for (; i + lanes <= count; i += lanes) {
    PromoteVector(d, from + i, to + i);
  }
  for (; i < count; ++i) {
    PromoteVector(hn::CappedTag<float, 1>(), from + i, to + i);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace structnerf
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace structnerf {

HWY_EXPORT(Demote);
HWY_EXPORT(Promote);

void HalfFromFloat(const float* from, const size_t count, hwy::float16_t* to) {
  HWY_DYNAMIC_DISPATCH(Demote)(from, count, to);
}

void FloatFromHalf(const hwy::float16_t* from, const size_t count, float* to) {
  HWY_DYNAMIC_DISPATCH(Promote)(from, count, to);
}

}  // namespace structnerf
#endif  // HWY_ONCE
