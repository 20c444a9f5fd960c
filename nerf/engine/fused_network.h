#pragma once

#include "nerf/field/field_layout.h"
#include "nerf/util/aligned_buffer.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace structnerf {

// The field's two networks on one tile of samples, forward and backward, with
// activations in buffers that stay in the second-level cache. Matrices are
// row-major, one row per sample.
class FusedNetwork {
 public:
  // Activations of up to `capacity` samples.
  struct Buffers {
    Buffers(const FieldLayout& layout, size_t capacity);

    AlignedBuffer<float> encoding;        // encoding_width; input
    AlignedBuffer<float> density_hidden;  // hidden_width
    AlignedBuffer<float> geometry;        // kGeometryWidth; [0] = raw density

    // Rows of the colour network belong to active samples only.
    AlignedBuffer<float> color_input;   // kColorInputWidth
    AlignedBuffer<float> color_hidden;  // hidden_width
    AlignedBuffer<float> color;         // kColorOutputWidth, [0, 3) used

    AlignedBuffer<float> d_color;        // by colour before the sigmoid; input
    AlignedBuffer<float> d_raw_density;  // kGeometryWidth, [0] used; input
    AlignedBuffer<float> d_color_input;
    AlignedBuffer<float> d_hidden;
    AlignedBuffer<float> d_geometry;
  };

  explicit FusedNetwork(const FieldLayout& layout);

  // Copies the parameters, and the transposed weights the backward pass reads.
  void SetParameters(const float* network);

  // encoding -> geometry.
  void ForwardDensity(size_t num_samples, Buffers* buffers) const;

  // geometry and direction -> color, for the listed samples. `direction` has a
  // row of kDirectionWidth per ray; sample s belongs to ray s /
  // samples_per_ray.
  void ForwardColor(const uint32_t* active,
                    size_t num_active,
                    size_t samples_per_ray,
                    const float* direction,
                    Buffers* buffers) const;

  // d_color -> d_geometry of all samples and parameter gradients, which are
  // added to `gradient` (laid out as the parameters).
  void BackwardColor(const uint32_t* active,
                     size_t num_active,
                     size_t num_samples,
                     Buffers* buffers,
                     float* gradient) const;

  // d_geometry and d_raw_density -> d_encoding and parameter gradients.
  void BackwardDensity(size_t num_samples,
                       Buffers* buffers,
                       float* gradient,
                       float* d_encoding) const;

 private:
  const FieldLayout layout_;
  AlignedBuffer<float> parameters_;
  AlignedBuffer<float> transposed_;  // weights only, at the same offsets
};

}  // namespace structnerf
