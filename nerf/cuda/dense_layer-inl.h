#pragma once

#include "nerf/cuda/host_device.h"

#include <cmath>
#include <cstddef>
#include <cstdint>

namespace structnerf {

// The kernels of nerf/kernels/dense_layer.h, y = x w + b, one call per element
// of the result. All matrices are row-major; rows are samples. At the widths of
// a field's networks, the weights stay in the first-level cache, and
// neighbouring threads read neighbouring columns of them and the same element
// of the other factor.

enum class Activation { kNone, kRectify, kSigmoid };

// sum + the product of a row with the first `count` rows of a column.
STRUCTNERF_HOST_DEVICE inline float AddRowTimesColumn(const float* row,
                                                      const float* column,
                                                      const uint32_t stride,
                                                      const uint32_t count,
                                                      float sum) {
  for (uint32_t k = 0; k < count; ++k) {
    sum += row[k] * column[k * stride];
  }
  return sum;
}

// Call i writes element i of y, rows x num_outputs.
struct DenseForwardKernel {
  const float* x;  // rows x num_inputs
  const float* w;  // num_inputs x w_stride, the first num_outputs columns count
  const float* b;  // num_outputs; one row of them per `rows_per_bias` rows
  uint32_t rows_per_bias;  // 0 = one row for all
  uint32_t num_inputs;
  uint32_t num_outputs;
  uint32_t w_stride;
  Activation activation;
  float* y;

  STRUCTNERF_HOST_DEVICE void operator()(const size_t i) const {
    const size_t row = i / num_outputs;
    const uint32_t column = static_cast<uint32_t>(i % num_outputs);
    const size_t bias_row = rows_per_bias == 0 ? 0 : row / rows_per_bias;
    float sum = AddRowTimesColumn(x + row * num_inputs,
                                  w + column,
                                  w_stride,
                                  num_inputs,
                                  b[bias_row * num_outputs + column]);
    if (activation == Activation::kRectify) {
      sum = sum > 0 ? sum : 0.0f;
    } else if (activation == Activation::kSigmoid) {
      sum = 1.0f / (1.0f + expf(-sum));
    }
    y[i] = sum;
  }
};

// Call i writes element i of `transposed`, num_columns x num_rows: the first
// num_columns of a matrix with rows of `stride` elements.
struct TransposeKernel {
  const float* matrix;
  uint32_t num_rows;
  uint32_t stride;
  float* transposed;

  STRUCTNERF_HOST_DEVICE void operator()(const size_t i) const {
    transposed[i] = matrix[i % num_rows * stride + i / num_rows];
  }
};

// dx = dy w^T. Call i writes element i of dx, rows x num_inputs.
struct DenseBackwardInputKernel {
  const float* dy;            // rows x num_outputs
  const float* w_transposed;  // num_outputs x num_inputs
  const float* activation;    // rectified x: dx is zero where it is; or null
  uint32_t num_inputs;
  uint32_t num_outputs;
  float* dx;

  STRUCTNERF_HOST_DEVICE void operator()(const size_t i) const {
    if (activation != nullptr && !(activation[i] > 0)) {
      dx[i] = 0;
      return;
    }
    const size_t row = i / num_inputs;
    const uint32_t column = static_cast<uint32_t>(i % num_inputs);
    dx[i] = AddRowTimesColumn(dy + row * num_outputs,
                              w_transposed + column,
                              num_inputs,
                              num_outputs,
                              /*sum=*/0);
  }
};

// The gradient by weights, and by biases where they follow the weights, of
// chunks of rows: dw = x^T dy, db = sum of dy. Call i writes element i of
// chunks x (num_inputs + has_biases) x num_outputs. Sums over chunks in a fixed
// order (SumChunksKernel) keep results the same from run to run.
struct DenseBackwardWeightsKernel {
  static constexpr uint32_t kChunkRows = 256;

  const float* x;   // rows x num_inputs
  const float* dy;  // rows x num_outputs
  size_t num_rows;
  uint32_t num_inputs;
  uint32_t num_outputs;
  uint32_t w_stride;
  bool has_biases;
  size_t chunk_stride;  // of dw
  float* dw;            // of the first chunk

  static size_t NumChunks(const size_t num_rows) {
    return (num_rows + kChunkRows - 1) / kChunkRows;
  }
  size_t NumCalls() const {
    return NumChunks(num_rows) * (num_inputs + has_biases) * num_outputs;
  }

  STRUCTNERF_HOST_DEVICE void operator()(const size_t i) const {
    const uint32_t column = static_cast<uint32_t>(i % num_outputs);
    const size_t chunk_and_input = i / num_outputs;
    const uint32_t input =
        static_cast<uint32_t>(chunk_and_input % (num_inputs + has_biases));
    const size_t chunk = chunk_and_input / (num_inputs + has_biases);
    const size_t begin = chunk * kChunkRows;
    const size_t end =
        begin + kChunkRows < num_rows ? begin + kChunkRows : num_rows;
    float sum = 0;
    for (size_t row = begin; row < end; ++row) {
      const float factor =
          input < num_inputs ? x[row * num_inputs + input] : 1.0f;
      sum += factor * dy[row * num_outputs + column];
    }
    dw[chunk * chunk_stride + input * w_stride + column] = sum;
  }
};

// sums[i] += sum over chunks of parts[chunk * chunk_stride + i].
struct SumChunksKernel {
  const float* parts;
  size_t num_chunks;
  size_t chunk_stride;
  float* sums;

  STRUCTNERF_HOST_DEVICE void operator()(const size_t i) const {
    float sum = sums[i];
    for (size_t chunk = 0; chunk < num_chunks; ++chunk) {
      sum += parts[chunk * chunk_stride + i];
    }
    sums[i] = sum;
  }
};

// Sums of `group_rows` consecutive rows of x. Call i writes element i of sums,
// groups x width.
struct SumGroupsKernel {
  const float* x;
  uint32_t group_rows;
  uint32_t width;
  float* sums;

  STRUCTNERF_HOST_DEVICE void operator()(const size_t i) const {
    const size_t group = i / width;
    const float* const first = x + group * group_rows * width + i % width;
    float sum = 0;
    for (uint32_t row = 0; row < group_rows; ++row) {
      sum += first[row * width];
    }
    sums[i] = sum;
  }
};

// to[i] = from[i * stride].
struct CopyColumnKernel {
  const float* from;
  uint32_t stride;
  float* to;

  STRUCTNERF_HOST_DEVICE void operator()(const size_t i) const {
    to[i] = from[i * stride];
  }
};

// to[i * stride] += from[i].
struct AddToColumnKernel {
  const float* from;
  uint32_t stride;
  float* to;

  STRUCTNERF_HOST_DEVICE void operator()(const size_t i) const {
    to[i * stride] += from[i];
  }
};

}  // namespace structnerf
