#pragma once

#include <cstddef>

namespace structnerf {

// Matrix kernels of small fully connected layers. All matrices are row-major
// floats; rows are samples. Widths of outputs are multiples of 16, row strides
// equal widths. Every function runs the best instruction set the machine has.

// y = x w + b, then y = max(y, 0) if `rectify`.
//   x: rows x num_inputs, w: num_inputs x num_outputs,
//   b: num_outputs or null, y: rows x num_outputs.
void DenseForward(const float* x,
                  const float* w,
                  const float* b,
                  size_t rows,
                  size_t num_inputs,
                  size_t num_outputs,
                  bool rectify,
                  float* y);

// Gradient with respect to the inputs: dx = dy w^T. Where `activation` is given
// (rows x num_inputs, the rectified values that were x), entries of dx are set
// to zero where it is not positive.
//   w_transposed: num_outputs x num_inputs; num_inputs a multiple of 16.
void DenseBackwardInput(const float* dy,
                        const float* w_transposed,
                        const float* activation,
                        size_t rows,
                        size_t num_inputs,
                        size_t num_outputs,
                        float* dx);

// Gradient with respect to the parameters, added to what is there:
// dw += x^T dy, db += column sums of dy.
void DenseBackwardParameters(const float* x,
                             const float* dy,
                             size_t rows,
                             size_t num_inputs,
                             size_t num_outputs,
                             float* dw,
                             float* db);

}  // namespace structnerf
