#pragma once

#include <cstddef>
#include <cstdint>

namespace structnerf {

// Matrix kernels of small fully connected layers, y = x w + b. All matrices are
// row-major floats; rows are samples. Row strides equal widths unless given.
// Widths that vectors run along are multiples of 16: num_outputs of the forward
// and the parameter kernels, num_inputs of the input kernel. Every function
// runs the best instruction set the machine has.

// y = x w + b, then y = max(y, 0) if `rectify`.
//   x: rows x num_inputs, w: num_inputs x num_outputs, y: rows x num_outputs.
//   b: num_outputs. With `groups`, row r uses the groups[r]-th row of b
//   instead.
void DenseForward(const float* x,
                  const float* w,
                  const float* b,
                  const uint32_t* groups,
                  size_t rows,
                  size_t num_inputs,
                  size_t num_outputs,
                  bool rectify,
                  float* y);

// Gradient with respect to the inputs: dx = dy w^T. Where `activation` is given
// (rows x num_inputs, the rectified values that were x), entries of dx are set
// to zero where it is not positive.
//   dy: rows x num_outputs, with a stride between rows.
//   w_transposed: num_outputs x num_inputs.
void DenseBackwardInput(const float* dy,
                        size_t dy_stride,
                        const float* w_transposed,
                        const float* activation,
                        size_t rows,
                        size_t num_inputs,
                        size_t num_outputs,
                        float* dx);

// Gradient with respect to the weights, added to what is there: dw += x^T dy.
//   x: rows x num_inputs, with a stride between rows.
void DenseBackwardWeights(const float* x,
                          size_t x_stride,
                          const float* dy,
                          size_t rows,
                          size_t num_inputs,
                          size_t num_outputs,
                          float* dw);

// sums[groups[r]] += x[r] over all rows; without groups, all rows go to the
// first. With x = dy this is the gradient with respect to the biases.
//   x: rows x width, width a multiple of 16.
void DenseSumRows(const float* x,
                  const uint32_t* groups,
                  size_t rows,
                  size_t width,
                  float* sums);

// x = 1 / (1 + exp(-x)) for `count` numbers, a multiple of 16.
void Sigmoid(size_t count, float* x);

}  // namespace structnerf
