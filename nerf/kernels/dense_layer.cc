#include "nerf/kernels/dense_layer.h"

// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nerf/kernels/dense_layer.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace structnerf {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<float, 16>;
using V = hn::VFromD<D>;

// Rows of a register block: accumulators, two weight vectors and a broadcast
// must fit into 32 registers with AVX-512 and 16 otherwise.
#if HWY_TARGET <= HWY_AVX3
constexpr size_t kBlockRows = 12;
#else
constexpr size_t kBlockRows = 6;
#endif

enum class Epilogue { kNone, kRectify, kMask };

// One block of kRows x (kVectors * lanes) of y = x w + b.
template <size_t kRows, size_t kVectors, Epilogue kEpilogue>
HWY_INLINE void MultiplyBlock(const float* HWY_RESTRICT x,
                              const float* HWY_RESTRICT w,
                              const float* HWY_RESTRICT b,
                              const float* HWY_RESTRICT activation,
                              const size_t num_inputs,
                              const size_t num_outputs,
                              float* HWY_RESTRICT y) {
  const D d;
  const size_t lanes = hn::Lanes(d);
  V sum[kRows][kVectors];
  for (size_t v = 0; v < kVectors; ++v) {
    const V start = b ? hn::LoadU(d, b + v * lanes) : hn::Zero(d);
    for (size_t r = 0; r < kRows; ++r) {
      sum[r][v] = start;
    }
  }
  for (size_t k = 0; k < num_inputs; ++k) {
    V weight[kVectors];
    for (size_t v = 0; v < kVectors; ++v) {
      weight[v] = hn::LoadU(d, w + k * num_outputs + v * lanes);
    }
    for (size_t r = 0; r < kRows; ++r) {
      const V value = hn::Set(d, x[r * num_inputs + k]);
      for (size_t v = 0; v < kVectors; ++v) {
        sum[r][v] = hn::MulAdd(value, weight[v], sum[r][v]);
      }
    }
  }
  for (size_t r = 0; r < kRows; ++r) {
    for (size_t v = 0; v < kVectors; ++v) {
      const size_t offset = r * num_outputs + v * lanes;
      if (kEpilogue == Epilogue::kRectify) {
        sum[r][v] = hn::Max(sum[r][v], hn::Zero(d));
      } else if (kEpilogue == Epilogue::kMask) {
        const auto positive =
            hn::Gt(hn::LoadU(d, activation + offset), hn::Zero(d));
        sum[r][v] = hn::IfThenElseZero(positive, sum[r][v]);
      }
      hn::StoreU(sum[r][v], d, y + offset);
    }
  }
}

template <size_t kVectors, Epilogue kEpilogue>
HWY_INLINE void MultiplyColumns(const float* HWY_RESTRICT x,
                                const float* HWY_RESTRICT w,
                                const float* HWY_RESTRICT b,
                                const float* HWY_RESTRICT activation,
                                const size_t rows,
                                const size_t num_inputs,
                                const size_t num_outputs,
                                float* HWY_RESTRICT y) {
  size_t r = 0;
  for (; r + kBlockRows <= rows; r += kBlockRows) {
    MultiplyBlock<kBlockRows, kVectors, kEpilogue>(x + r * num_inputs,
                                                   w,
                                                   b,
                                                   activation + r * num_outputs,
                                                   num_inputs,
                                                   num_outputs,
                                                   y + r * num_outputs);
  }
  for (; r < rows; ++r) {
    MultiplyBlock<1, kVectors, kEpilogue>(x + r * num_inputs,
                                          w,
                                          b,
                                          activation + r * num_outputs,
                                          num_inputs,
                                          num_outputs,
                                          y + r * num_outputs);
  }
}

template <Epilogue kEpilogue>
void Multiply(const float* x,
              const float* w,
              const float* b,
              const float* activation,
              const size_t rows,
              const size_t num_inputs,
              const size_t num_outputs,
              float* y) {
  const size_t lanes = hn::Lanes(D());
  size_t column = 0;
  for (; column + 2 * lanes <= num_outputs; column += 2 * lanes) {
    MultiplyColumns<2, kEpilogue>(x,
                                  w + column,
                                  b ? b + column : nullptr,
                                  activation + column,
                                  rows,
                                  num_inputs,
                                  num_outputs,
                                  y + column);
  }
  for (; column < num_outputs; column += lanes) {
    MultiplyColumns<1, kEpilogue>(x,
                                  w + column,
                                  b ? b + column : nullptr,
                                  activation + column,
                                  rows,
                                  num_inputs,
                                  num_outputs,
                                  y + column);
  }
}

void Forward(const float* x,
             const float* w,
             const float* b,
             const size_t rows,
             const size_t num_inputs,
             const size_t num_outputs,
             const bool rectify,
             float* y) {
  // The unused activation only has to be a valid pointer to do arithmetic on.
  if (rectify) {
    Multiply<Epilogue::kRectify>(x, w, b, x, rows, num_inputs, num_outputs, y);
  } else {
    Multiply<Epilogue::kNone>(x, w, b, x, rows, num_inputs, num_outputs, y);
  }
}

void BackwardInput(const float* dy,
                   const float* w_transposed,
                   const float* activation,
                   const size_t rows,
                   const size_t num_inputs,
                   const size_t num_outputs,
                   float* dx) {
  if (activation) {
    Multiply<Epilogue::kMask>(dy,
                              w_transposed,
                              nullptr,
                              activation,
                              rows,
                              num_outputs,
                              num_inputs,
                              dx);
  } else {
    Multiply<Epilogue::kNone>(
        dy, w_transposed, nullptr, dy, rows, num_outputs, num_inputs, dx);
  }
}

// One block of kInputs x (kVectors * lanes) of dw += x^T dy.
template <size_t kInputs, size_t kVectors>
HWY_INLINE void AccumulateBlock(const float* HWY_RESTRICT x,
                                const float* HWY_RESTRICT dy,
                                const size_t rows,
                                const size_t num_inputs,
                                const size_t num_outputs,
                                float* HWY_RESTRICT dw) {
  const D d;
  const size_t lanes = hn::Lanes(d);
  V sum[kInputs][kVectors];
  for (size_t k = 0; k < kInputs; ++k) {
    for (size_t v = 0; v < kVectors; ++v) {
      sum[k][v] = hn::LoadU(d, dw + k * num_outputs + v * lanes);
    }
  }
  for (size_t r = 0; r < rows; ++r) {
    V gradient[kVectors];
    for (size_t v = 0; v < kVectors; ++v) {
      gradient[v] = hn::LoadU(d, dy + r * num_outputs + v * lanes);
    }
    for (size_t k = 0; k < kInputs; ++k) {
      const V value = hn::Set(d, x[r * num_inputs + k]);
      for (size_t v = 0; v < kVectors; ++v) {
        sum[k][v] = hn::MulAdd(value, gradient[v], sum[k][v]);
      }
    }
  }
  for (size_t k = 0; k < kInputs; ++k) {
    for (size_t v = 0; v < kVectors; ++v) {
      hn::StoreU(sum[k][v], d, dw + k * num_outputs + v * lanes);
    }
  }
}

template <size_t kVectors>
HWY_INLINE void AccumulateColumns(const float* HWY_RESTRICT x,
                                  const float* HWY_RESTRICT dy,
                                  const size_t rows,
                                  const size_t num_inputs,
                                  const size_t num_outputs,
                                  float* HWY_RESTRICT dw,
                                  float* HWY_RESTRICT db) {
  size_t k = 0;
  for (; k + kBlockRows <= num_inputs; k += kBlockRows) {
    AccumulateBlock<kBlockRows, kVectors>(
        x + k, dy, rows, num_inputs, num_outputs, dw + k * num_outputs);
  }
  for (; k + 4 <= num_inputs; k += 4) {
    AccumulateBlock<4, kVectors>(
        x + k, dy, rows, num_inputs, num_outputs, dw + k * num_outputs);
  }
  for (; k < num_inputs; ++k) {
    AccumulateBlock<1, kVectors>(
        x + k, dy, rows, num_inputs, num_outputs, dw + k * num_outputs);
  }
  const D d;
  const size_t lanes = hn::Lanes(d);
  for (size_t v = 0; v < kVectors; ++v) {
    V sum = hn::LoadU(d, db + v * lanes);
    for (size_t r = 0; r < rows; ++r) {
      sum = hn::Add(sum, hn::LoadU(d, dy + r * num_outputs + v * lanes));
    }
    hn::StoreU(sum, d, db + v * lanes);
  }
}

void BackwardParameters(const float* x,
                        const float* dy,
                        const size_t rows,
                        const size_t num_inputs,
                        const size_t num_outputs,
                        float* dw,
                        float* db) {
  const size_t lanes = hn::Lanes(D());
  size_t column = 0;
  for (; column + 2 * lanes <= num_outputs; column += 2 * lanes) {
    AccumulateColumns<2>(x,
                         dy + column,
                         rows,
                         num_inputs,
                         num_outputs,
                         dw + column,
                         db + column);
  }
  for (; column < num_outputs; column += lanes) {
    AccumulateColumns<1>(x,
                         dy + column,
                         rows,
                         num_inputs,
                         num_outputs,
                         dw + column,
                         db + column);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace structnerf
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace structnerf {

HWY_EXPORT(Forward);
HWY_EXPORT(BackwardInput);
HWY_EXPORT(BackwardParameters);

void DenseForward(const float* x,
                  const float* w,
                  const float* b,
                  const size_t rows,
                  const size_t num_inputs,
                  const size_t num_outputs,
                  const bool rectify,
                  float* y) {
  HWY_DYNAMIC_DISPATCH(Forward)
  (x, w, b, rows, num_inputs, num_outputs, rectify, y);
}

void DenseBackwardInput(const float* dy,
                        const float* w_transposed,
                        const float* activation,
                        const size_t rows,
                        const size_t num_inputs,
                        const size_t num_outputs,
                        float* dx) {
  HWY_DYNAMIC_DISPATCH(BackwardInput)
  (dy, w_transposed, activation, rows, num_inputs, num_outputs, dx);
}

void DenseBackwardParameters(const float* x,
                             const float* dy,
                             const size_t rows,
                             const size_t num_inputs,
                             const size_t num_outputs,
                             float* dw,
                             float* db) {
  HWY_DYNAMIC_DISPATCH(BackwardParameters)
  (x, dy, rows, num_inputs, num_outputs, dw, db);
}

}  // namespace structnerf
#endif  // HWY_ONCE
