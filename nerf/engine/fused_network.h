#pragma once

#include "nerf/field/field_layout.h"
#include "nerf/util/aligned_buffer.h"

#include <cstddef>
#include <cstdint>

namespace structnerf {

// The field's two networks on one tile of samples, forward and backward, with
// activations in buffers that stay in the second-level cache. Matrices are
// row-major, one row per sample.
//
// The colour network runs on the active samples only. What the viewing
// direction adds to its hidden layer is the same for all samples of a ray and
// computed per ray.
class FusedNetwork {
 public:
  // Samples whose colour is evaluated, in the order of their rays.
  struct ActiveSamples {
    const uint32_t* samples = nullptr;
    const uint32_t* rays = nullptr;  // the ray each belongs to
    size_t count = 0;
  };

  // Activations of a tile.
  struct Buffers {
    Buffers(const FieldLayout& layout, size_t num_rays, size_t num_samples);

    AlignedBuffer<float> encoding;        // encoding_width; input
    AlignedBuffer<float> density_hidden;  // hidden_width
    AlignedBuffer<float> geometry;        // kGeometryWidth; [0] = raw density

    AlignedBuffer<float> direction;         // rays x kDirectionWidth; input
    AlignedBuffer<float> direction_hidden;  // rays x hidden_width

    // Rows belong to active samples.
    AlignedBuffer<float> color_geometry;  // kGeometryWidth
    AlignedBuffer<float> color_hidden;    // hidden_width
    AlignedBuffer<float> color;           // kColorOutputWidth, [0, 3) used

    // Gradients by color before its sigmoid, [0, 3) used, and by the raw
    // density, both inputs of the backward pass; and by the encoding.
    AlignedBuffer<float> d_color;        // active samples x kColorOutputWidth
    AlignedBuffer<float> d_raw_density;  // one number per sample
    AlignedBuffer<float> d_encoding;     // encoding_width

    AlignedBuffer<float> d_color_geometry;
    AlignedBuffer<float> d_color_output_weights;  // transposed
    AlignedBuffer<float> d_direction_hidden;
    AlignedBuffer<float> d_hidden;
    AlignedBuffer<float> d_geometry;
  };

  explicit FusedNetwork(const FieldLayout& layout);

  // Copies the parameters, and the transposed weights the backward pass reads.
  void SetParameters(const float* network);

  // encoding -> geometry.
  void ForwardDensity(size_t num_samples, Buffers* buffers) const;

  // geometry and direction -> color of the active samples.
  void ForwardColor(const ActiveSamples& active,
                    size_t num_rays,
                    Buffers* buffers) const;

  // d_color and d_raw_density -> d_encoding. Adds the gradient by the
  // parameters, laid out as these, to `gradient`.
  void Backward(const ActiveSamples& active,
                size_t num_rays,
                size_t num_samples,
                Buffers* buffers,
                float* gradient) const;

 private:
  void BackwardColor(const ActiveSamples& active,
                     size_t num_rays,
                     Buffers* buffers,
                     float* gradient) const;

  const FieldLayout layout_;
  AlignedBuffer<float> parameters_;
  AlignedBuffer<float> transposed_;  // weights only, at the same offsets
};

}  // namespace structnerf
