#include "nerf/kernels/adam.h"

#include <cmath>

// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nerf/kernels/adam.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace structnerf {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

template <class D>
HWY_INLINE void UpdateVector(const D d,
                             const AdamStep& step,
                             const hn::VFromD<D> gradient,
                             float* first_moment,
                             float* second_moment,
                             float* value) {
  const auto m = hn::MulAdd(hn::Set(d, step.beta1),
                            hn::LoadU(d, first_moment),
                            hn::Mul(hn::Set(d, 1 - step.beta1), gradient));
  const auto v = hn::MulAdd(
      hn::Set(d, step.beta2),
      hn::LoadU(d, second_moment),
      hn::Mul(hn::Set(d, 1 - step.beta2), hn::Mul(gradient, gradient)));
  const auto denominator = hn::Add(hn::Sqrt(v), hn::Set(d, step.epsilon));
  const auto change =
      hn::Div(hn::Mul(hn::Set(d, step.learning_rate), m), denominator);
  hn::StoreU(m, d, first_moment);
  hn::StoreU(v, d, second_moment);
  hn::StoreU(hn::Sub(hn::LoadU(d, value), change), d, value);
}

// Also false for NaN.
template <class D>
HWY_INLINE bool AllFinite(const D d, const hn::VFromD<D> v) {
  return hn::AllTrue(d, hn::Lt(hn::Abs(v), hn::Set(d, kMaxGradient)));
}

bool UpdateEntry(const AdamStep& step,
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
      UpdateVector(d,
                   step,
                   hn::LoadU(d, gradient + f),
                   state->first_moment + f,
                   state->second_moment + f,
                   state->value + f);
      hn::StoreU(
          hn::DemoteTo(dh, hn::LoadU(d, state->value + f)), dh, table + f);
    }
  }
  for (size_t f = 0; f < 8; f += lanes) {
    hn::StoreU(hn::Zero(d), d, gradient + f);
  }
  return is_finite;
}

bool UpdateGrid(const AdamStep& step,
                const size_t block_begin,
                const size_t block_end,
                uint64_t* touched_blocks,
                float* gradient,
                GridEntryState* state,
                hwy::float16_t* table) {
  bool is_finite = true;
  for (size_t word = block_begin / 64; word < (block_end + 63) / 64; ++word) {
    uint64_t bits = touched_blocks[word];
    touched_blocks[word] = 0;
    while (bits != 0) {
      const size_t block = word * 64 + hwy::Num0BitsBelowLS1Bit_Nonzero64(bits);
      bits &= bits - 1;
      for (size_t entry = block * 8; entry < block * 8 + 8; ++entry) {
        is_finite &= UpdateEntry(
            step, gradient + entry * 8, state + entry, table + entry * 8);
      }
    }
  }
  return is_finite;
}

void Update(const AdamStep& step,
            const size_t count,
            const float* gradient,
            float* first_moment,
            float* second_moment,
            float* value) {
  const hn::CappedTag<float, 16> d;
  const hn::CappedTag<float, 1> d1;
  const size_t lanes = hn::Lanes(d);
  size_t i = 0;
  for (; i + lanes <= count; i += lanes) {
    UpdateVector(d,
                 step,
                 hn::LoadU(d, gradient + i),
                 first_moment + i,
                 second_moment + i,
                 value + i);
  }
  for (; i < count; ++i) {
    UpdateVector(d1,
                 step,
                 hn::LoadU(d1, gradient + i),
                 first_moment + i,
                 second_moment + i,
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
                    const size_t block_begin,
                    const size_t block_end,
                    uint64_t* touched_blocks,
                    float* gradient,
                    GridEntryState* state,
                    hwy::float16_t* table) {
  return HWY_DYNAMIC_DISPATCH(UpdateGrid)(
      step, block_begin, block_end, touched_blocks, gradient, state, table);
}

void AdamUpdate(const AdamStep& step,
                const size_t count,
                const float* gradient,
                float* first_moment,
                float* second_moment,
                float* value) {
  HWY_DYNAMIC_DISPATCH(Update)
  (step, count, gradient, first_moment, second_moment, value);
}

}  // namespace structnerf
#endif  // HWY_ONCE
