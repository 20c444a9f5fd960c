#include "nerf/kernels/adam.h"

#include <algorithm>

// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nerf/kernels/adam.cc"
#include <hwy/foreach_target.h>
#include <hwy/cache_control.h>
#include <hwy/highway.h>
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace structnerf {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// 1 / sqrt(x) to float precision, x > 0.
template <class D, class V = hn::VFromD<D>>
HWY_INLINE V ReciprocalSqrt(const D d, const V x) {
  const V guess = hn::ApproximateReciprocalSqrt(x);
  const V error =
      hn::NegMulAdd(hn::Mul(x, guess), guess, hn::Set(d, 1.0f));  // Newton
  return hn::MulAdd(hn::Mul(hn::Set(d, 0.5f), guess), error, guess);
}

// Replaces the moments by the new ones, the second by its root, and returns the
// change of the values.
template <class D, class V = hn::VFromD<D>>
HWY_INLINE V UpdateMoments(const D d,
                           const AdamStep& step,
                           const V gradient,
                           V* first_moment,
                           V* root_second_moment) {
  *first_moment = hn::MulAdd(hn::Set(d, 1 - step.beta1),
                             hn::Sub(gradient, *first_moment),
                             *first_moment);
  const V old_second_moment = hn::Mul(*root_second_moment, *root_second_moment);
  const V second_moment = hn::MulAdd(
      hn::Set(d, step.beta2),
      old_second_moment,
      hn::Mul(hn::Set(d, 1 - step.beta2), hn::Mul(gradient, gradient)));
  const V inverse_root = ReciprocalSqrt(
      d, hn::Add(second_moment, hn::Set(d, step.epsilon * step.epsilon)));
  *root_second_moment = hn::Mul(second_moment, inverse_root);
  return hn::Mul(hn::Set(d, -step.learning_rate),
                 hn::Mul(*first_moment, inverse_root));
}

// The upper bits of floats, from `kShift` on, rounded to nearest.
template <int kShift, class D>
HWY_INLINE void StoreUpperBits(D /*d*/,
                               const hn::VFromD<D> v,
                               uint16_t* HWY_RESTRICT to) {
  const hn::RebindToUnsigned<D> du;
  const hn::RebindToSigned<D> di;
  const hn::Rebind<uint16_t, D> du16;
  const auto bits = hn::BitCast(du, v);
  const auto is_odd = hn::And(hn::ShiftRight<kShift>(bits), hn::Set(du, 1));
  const auto rounded = hn::ShiftRight<kShift>(hn::Add(
      bits, hn::Add(is_odd, hn::Set(du, (uint32_t{1} << (kShift - 1)) - 1))));
  hn::StoreU(hn::DemoteTo(du16, hn::BitCast(di, rounded)), du16, to);
}

template <int kShift, class D>
HWY_INLINE hn::VFromD<D> LoadUpperBits(const D d,
                                       const uint16_t* HWY_RESTRICT from) {
  const hn::RebindToUnsigned<D> du;
  const hn::Rebind<uint16_t, D> du16;
  return hn::BitCast(
      d, hn::ShiftLeft<kShift>(hn::PromoteTo(du, hn::LoadU(du16, from))));
}

// Also false for NaN.
template <class D>
HWY_INLINE bool AllFinite(const D d, const hn::VFromD<D> v) {
  return hn::AllTrue(d, hn::Lt(hn::Abs(v), hn::Set(d, kMaxGradient)));
}

// Entries ahead of which state is requested from memory.
constexpr size_t kPrefetchDistance = 16;

HWY_INLINE bool UpdateEntry(const AdamStep& step,
                            float* HWY_RESTRICT gradient,
                            GridEntryState* HWY_RESTRICT state,
                            hwy::float16_t* HWY_RESTRICT table) {
  const hn::CappedTag<float, 8> d;
  const hn::Rebind<hwy::float16_t, decltype(d)> dh;
  const size_t lanes = hn::Lanes(d);
  bool is_zero = true;
  bool is_finite = true;
  for (size_t f = 0; f < 8; f += lanes) {
    const auto g = hn::LoadU(d, gradient + f);
    is_zero &= hn::AllTrue(d, hn::Eq(g, hn::Zero(d)));
    is_finite &= AllFinite(d, g);
  }
  if (!is_zero && is_finite) {
    for (size_t f = 0; f < 8; f += lanes) {
      auto m = LoadUpperBits<16>(d, state->first_moment + f);
      auto root_v = LoadUpperBits<15>(d, state->root_second_moment + f);
      const auto change =
          UpdateMoments(d, step, hn::LoadU(d, gradient + f), &m, &root_v);
      const auto value = hn::Add(hn::LoadU(d, state->value + f), change);
      StoreUpperBits<16>(d, m, state->first_moment + f);
      StoreUpperBits<15>(d, root_v, state->root_second_moment + f);
      hn::StoreU(value, d, state->value + f);
      hn::StoreU(hn::DemoteTo(dh, value), dh, table + f);
    }
  }
  for (size_t f = 0; f < 8; f += lanes) {
    hn::StoreU(hn::Zero(d), d, gradient + f);
  }
  return is_finite;
}

bool UpdateGrid(const AdamStep& step,
                const uint16_t* HWY_RESTRICT entries,
                const size_t num_entries,
                float* HWY_RESTRICT gradient,
                GridEntryState* HWY_RESTRICT state,
                hwy::float16_t* HWY_RESTRICT table) {
  bool is_finite = true;
  for (size_t i = 0; i < num_entries; ++i) {
    const size_t ahead =
        entries[std::min(i + kPrefetchDistance, num_entries - 1)];
    hwy::Prefetch(state + ahead);
    hwy::Prefetch(table + ahead * 8);
    const size_t entry = entries[i];
    is_finite &= UpdateEntry(
        step, gradient + entry * 8, state + entry, table + entry * 8);
  }
  return is_finite;
}

template <class D>
HWY_INLINE void UpdateVector(const D d,
                             const AdamStep& step,
                             const float* gradient,
                             float* first_moment,
                             float* root_second_moment,
                             float* value) {
  auto m = hn::LoadU(d, first_moment);
  auto root_v = hn::LoadU(d, root_second_moment);
  const auto change =
      UpdateMoments(d, step, hn::LoadU(d, gradient), &m, &root_v);
  hn::StoreU(m, d, first_moment);
  hn::StoreU(root_v, d, root_second_moment);
  hn::StoreU(hn::Add(hn::LoadU(d, value), change), d, value);
}

void Update(const AdamStep& step,
            const size_t count,
            const float* gradient,
            float* first_moment,
            float* root_second_moment,
            float* value) {
  const hn::CappedTag<float, 16> d;
  const hn::CappedTag<float, 1> d1;
  const size_t lanes = hn::Lanes(d);
  size_t i = 0;
  for (; i + lanes <= count; i += lanes) {
    UpdateVector(d,
                 step,
                 gradient + i,
                 first_moment + i,
                 root_second_moment + i,
                 value + i);
  }
  for (; i < count; ++i) {
    UpdateVector(d1,
                 step,
                 gradient + i,
                 first_moment + i,
                 root_second_moment + i,
                 value + i);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace structnerf
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace structnerf {

HWY_EXPORT(UpdateGrid);
HWY_EXPORT(Update);

bool AdamUpdateGrid(const AdamStep& step,
                    const uint16_t* entries,
                    const size_t num_entries,
                    float* gradient,
                    GridEntryState* state,
                    hwy::float16_t* table) {
  return HWY_DYNAMIC_DISPATCH(UpdateGrid)(
      step, entries, num_entries, gradient, state, table);
}

void AdamUpdate(const AdamStep& step,
                const size_t count,
                const float* gradient,
                float* first_moment,
                float* root_second_moment,
                float* value) {
  HWY_DYNAMIC_DISPATCH(Update)
  (step, count, gradient, first_moment, root_second_moment, value);
}

}  // namespace structnerf
#endif  // HWY_ONCE
