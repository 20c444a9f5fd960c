#include "nerf/kernels/dense_layer.h"

// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nerf/kernels/dense_layer.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
#include <hwy/contrib/math/math-inl.h>
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace structnerf {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<float, 16>;
using V = hn::VFromD<D>;

// Rows of a register block that is one or two vectors wide, and rows of dw of
// one two vectors wide. Sums, two weight vectors and a broadcast must fit into
// the 32 registers of AVX-512 and the 16 of others; eight sums or more hide the
// latency of two multiply-add units.
#if HWY_TARGET <= HWY_AVX3
constexpr size_t kNarrowRows = 16;
constexpr size_t kWideRows = 8;
constexpr size_t kWeightRows = 8;
#else
constexpr size_t kNarrowRows = 12;
constexpr size_t kWideRows = 6;
constexpr size_t kWeightRows = 4;
#endif

struct Matrix {
  const float* data;
  size_t stride;
};

// What is done to sums before they are stored.
struct Plain {
  HWY_INLINE V operator()(const V sum, size_t) const { return sum; }
};
struct Rectify {
  HWY_INLINE V operator()(const V sum, size_t) const {
    return hn::Max(sum, hn::Zero(D()));
  }
};
struct Mask {
  HWY_INLINE V operator()(const V sum, const size_t offset) const {
    const D d;
    return hn::IfThenElseZero(
        hn::Gt(hn::LoadU(d, activation + offset), hn::Zero(d)), sum);
  }
  const float* activation;
};

// What sums start from, by row.
struct NoBias {
  HWY_INLINE V operator()(size_t, size_t) const { return hn::Zero(D()); }
};
struct Bias {
  HWY_INLINE V operator()(size_t, const size_t column) const {
    return hn::LoadU(D(), b + column);
  }
  const float* b;
};
struct GroupBias {
  HWY_INLINE V operator()(const size_t row, const size_t column) const {
    return hn::LoadU(D(), b + groups[row] * width + column);
  }
  const float* b;
  const uint32_t* groups;
  size_t width;
};

// kRows rows and kVectors vectors of columns of y = x w + start.
template <size_t kRows, size_t kVectors, class Start, class Finish>
HWY_INLINE void MultiplyBlock(const Matrix& x,
                              const float* HWY_RESTRICT w,
                              const size_t row,
                              const size_t column,
                              const size_t depth,
                              const size_t width,
                              const Start& start,
                              const Finish& finish,
                              float* HWY_RESTRICT y) {
  const D d;
  const size_t lanes = hn::Lanes(d);
  const float* HWY_RESTRICT x_rows = x.data + row * x.stride;
  V sum[kRows][kVectors];
  for (size_t r = 0; r < kRows; ++r) {
    for (size_t v = 0; v < kVectors; ++v) {
      sum[r][v] = start(row + r, column + v * lanes);
    }
  }
  for (size_t k = 0; k < depth; ++k) {
    V weight[kVectors];
    for (size_t v = 0; v < kVectors; ++v) {
      weight[v] = hn::LoadU(d, w + k * width + column + v * lanes);
    }
    for (size_t r = 0; r < kRows; ++r) {
      const V value = hn::Set(d, x_rows[r * x.stride + k]);
      for (size_t v = 0; v < kVectors; ++v) {
        sum[r][v] = hn::MulAdd(value, weight[v], sum[r][v]);
      }
    }
  }
  for (size_t r = 0; r < kRows; ++r) {
    for (size_t v = 0; v < kVectors; ++v) {
      const size_t offset = (row + r) * width + column + v * lanes;
      hn::StoreU(finish(sum[r][v], offset), d, y + offset);
    }
  }
}

template <size_t kRows, size_t kVectors, class Start, class Finish>
HWY_INLINE void MultiplyColumns(const Matrix& x,
                                const float* w,
                                const size_t column,
                                const size_t rows,
                                const size_t depth,
                                const size_t width,
                                const Start& start,
                                const Finish& finish,
                                float* y) {
  size_t row = 0;
  for (; row + kRows <= rows; row += kRows) {
    MultiplyBlock<kRows, kVectors>(
        x, w, row, column, depth, width, start, finish, y);
  }
  for (; row + 4 <= rows; row += 4) {
    MultiplyBlock<4, kVectors>(
        x, w, row, column, depth, width, start, finish, y);
  }
  for (; row < rows; ++row) {
    MultiplyBlock<1, kVectors>(
        x, w, row, column, depth, width, start, finish, y);
  }
}

// y = finish(x w + start), x: rows x depth, w: depth x width.
template <class Start, class Finish>
void Multiply(const Matrix& x,
              const float* w,
              const size_t rows,
              const size_t depth,
              const size_t width,
              const Start& start,
              const Finish& finish,
              float* y) {
  const size_t lanes = hn::Lanes(D());
  size_t column = 0;
  for (; column + 2 * lanes <= width; column += 2 * lanes) {
    MultiplyColumns<kWideRows, 2>(
        x, w, column, rows, depth, width, start, finish, y);
  }
  for (; column < width; column += lanes) {
    MultiplyColumns<kNarrowRows, 1>(
        x, w, column, rows, depth, width, start, finish, y);
  }
}

void Forward(const float* x,
             const float* w,
             const float* b,
             const uint32_t* groups,
             const size_t rows,
             const size_t num_inputs,
             const size_t num_outputs,
             const bool rectify,
             float* y) {
  const Matrix matrix{x, num_inputs};
  const auto multiply = [&](const auto& start, const auto& finish) HWY_ATTR {
    Multiply(matrix, w, rows, num_inputs, num_outputs, start, finish, y);
  };
  if (groups) {
    const GroupBias start{b, groups, num_outputs};
    rectify ? multiply(start, Rectify()) : multiply(start, Plain());
  } else {
    const Bias start{b};
    rectify ? multiply(start, Rectify()) : multiply(start, Plain());
  }
}

void BackwardInput(const float* dy,
                   const size_t dy_stride,
                   const float* w_transposed,
                   const float* activation,
                   const size_t rows,
                   const size_t num_inputs,
                   const size_t num_outputs,
                   float* dx) {
  const Matrix matrix{dy, dy_stride};
  const auto multiply = [&](const auto& finish) HWY_ATTR {
    Multiply(matrix,
             w_transposed,
             rows,
             num_outputs,
             num_inputs,
             NoBias(),
             finish,
             dx);
  };
  activation ? multiply(Mask{activation}) : multiply(Plain());
}

// kInputs rows and kVectors vectors of columns of dw += x^T dy.
template <size_t kInputs, size_t kVectors>
HWY_INLINE void AccumulateBlock(const Matrix& x,
                                const float* HWY_RESTRICT dy,
                                const size_t input,
                                const size_t column,
                                const size_t rows,
                                const size_t width,
                                float* HWY_RESTRICT dw) {
  const D d;
  const size_t lanes = hn::Lanes(d);
  float* HWY_RESTRICT dw_block = dw + input * width + column;
  V sum[kInputs][kVectors];
  for (size_t k = 0; k < kInputs; ++k) {
    for (size_t v = 0; v < kVectors; ++v) {
      sum[k][v] = hn::LoadU(d, dw_block + k * width + v * lanes);
    }
  }
  const float* HWY_RESTRICT x_row = x.data + input;
  const float* HWY_RESTRICT dy_row = dy + column;
  for (size_t r = 0; r < rows; ++r) {
    V gradient[kVectors];
    for (size_t v = 0; v < kVectors; ++v) {
      gradient[v] = hn::LoadU(d, dy_row + v * lanes);
    }
    for (size_t k = 0; k < kInputs; ++k) {
      const V value = hn::Set(d, x_row[k]);
      for (size_t v = 0; v < kVectors; ++v) {
        sum[k][v] = hn::MulAdd(value, gradient[v], sum[k][v]);
      }
    }
    x_row += x.stride;
    dy_row += width;
  }
  for (size_t k = 0; k < kInputs; ++k) {
    for (size_t v = 0; v < kVectors; ++v) {
      hn::StoreU(sum[k][v], d, dw_block + k * width + v * lanes);
    }
  }
}

template <size_t kInputs, size_t kVectors>
HWY_INLINE void AccumulateColumns(const Matrix& x,
                                  const float* dy,
                                  const size_t column,
                                  const size_t rows,
                                  const size_t num_inputs,
                                  const size_t width,
                                  float* dw) {
  size_t k = 0;
  for (; k + kInputs <= num_inputs; k += kInputs) {
    AccumulateBlock<kInputs, kVectors>(x, dy, k, column, rows, width, dw);
  }
  for (; k < num_inputs; ++k) {
    AccumulateBlock<1, kVectors>(x, dy, k, column, rows, width, dw);
  }
}

void BackwardWeights(const float* x,
                     const size_t x_stride,
                     const float* dy,
                     const size_t rows,
                     const size_t num_inputs,
                     const size_t num_outputs,
                     float* dw) {
  const Matrix matrix{x, x_stride};
  const size_t lanes = hn::Lanes(D());
  size_t column = 0;
  for (; column + 2 * lanes <= num_outputs; column += 2 * lanes) {
    AccumulateColumns<kWeightRows, 2>(
        matrix, dy, column, rows, num_inputs, num_outputs, dw);
  }
  for (; column < num_outputs; column += lanes) {
    AccumulateColumns<2 * kWeightRows, 1>(
        matrix, dy, column, rows, num_inputs, num_outputs, dw);
  }
}

void SumRows(const float* HWY_RESTRICT x,
             const uint32_t* HWY_RESTRICT groups,
             const size_t rows,
             const size_t width,
             float* HWY_RESTRICT sums) {
  const D d;
  const size_t lanes = hn::Lanes(d);
  for (size_t column = 0; column < width; column += lanes) {
    for (size_t r = 0; r < rows;) {
      // Rows of a group mostly follow each other.
      const size_t group = groups ? groups[r] : 0;
      V sum = hn::LoadU(d, sums + group * width + column);
      do {
        sum = hn::Add(sum, hn::LoadU(d, x + r * width + column));
        ++r;
      } while (r < rows && (!groups || groups[r] == group));
      hn::StoreU(sum, d, sums + group * width + column);
    }
  }
}

void SigmoidImpl(const size_t count, float* x) {
  const D d;
  const V one = hn::Set(d, 1.0f);
  for (size_t i = 0; i < count; i += hn::Lanes(d)) {
    // Beyond this, Exp would overflow.
    const V argument = hn::Min(hn::Set(d, 80.0f), hn::Neg(hn::LoadU(d, x + i)));
    const V exponential = hn::Exp(d, argument);
    hn::StoreU(hn::Div(one, hn::Add(one, exponential)), d, x + i);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace structnerf
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace structnerf {

HWY_EXPORT(Forward);
HWY_EXPORT(BackwardInput);
HWY_EXPORT(BackwardWeights);
HWY_EXPORT(SumRows);
HWY_EXPORT(SigmoidImpl);

void DenseForward(const float* x,
                  const float* w,
                  const float* b,
                  const uint32_t* groups,
                  const size_t rows,
                  const size_t num_inputs,
                  const size_t num_outputs,
                  const bool rectify,
                  float* y) {
  HWY_DYNAMIC_DISPATCH(Forward)
  (x, w, b, groups, rows, num_inputs, num_outputs, rectify, y);
}

void DenseBackwardInput(const float* dy,
                        const size_t dy_stride,
                        const float* w_transposed,
                        const float* activation,
                        const size_t rows,
                        const size_t num_inputs,
                        const size_t num_outputs,
                        float* dx) {
  HWY_DYNAMIC_DISPATCH(BackwardInput)
  (dy, dy_stride, w_transposed, activation, rows, num_inputs, num_outputs, dx);
}

void DenseBackwardWeights(const float* x,
                          const size_t x_stride,
                          const float* dy,
                          const size_t rows,
                          const size_t num_inputs,
                          const size_t num_outputs,
                          float* dw) {
  HWY_DYNAMIC_DISPATCH(BackwardWeights)
  (x, x_stride, dy, rows, num_inputs, num_outputs, dw);
}

void DenseSumRows(const float* x,
                  const uint32_t* groups,
                  const size_t rows,
                  const size_t width,
                  float* sums) {
  HWY_DYNAMIC_DISPATCH(SumRows)(x, groups, rows, width, sums);
}

void Sigmoid(const size_t count, float* x) {
  HWY_DYNAMIC_DISPATCH(SigmoidImpl)(count, x);
}

}  // namespace structnerf
#endif  // HWY_ONCE
