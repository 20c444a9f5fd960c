#pragma once

#include "nerf/cuda/dense_layer-inl.h"
#include "nerf/cuda/device_batch.h"
#include "nerf/field/field_layout.h"

#include <cstddef>
#include <cstdint>

namespace structnerf {

// The field's two networks on a batch (see FusedNetwork for those of the CPU).
// What the viewing direction adds to the hidden layer of colour is the same for
// all samples of a ray and computed per ray.
template <class Device>
class DeviceNetwork {
 public:
  using Batch = DeviceBatch<Device>;

  // `values`: num_network_parameters on the device, as `layout` says.
  DeviceNetwork(const FieldLayout& layout, const float* values, Device* device)
      : layout_(layout), values_(values), device_(device) {}

  // encoding -> geometry, raw_density.
  void ForwardDensity(Batch* batch) const {
    const size_t n = batch->NumSamples();
    Forward(layout_.density_hidden,
            batch->encoding.data(),
            n,
            Activation::kRectify,
            batch->density_hidden.data());
    Forward(layout_.density_output,
            batch->density_hidden.data(),
            n,
            Activation::kNone,
            batch->geometry.data());
    device_->Launch(
        CopyColumnKernel{
            batch->geometry.data(), kGeometryWidth, batch->raw_density.data()},
        n);
  }

  // geometry and direction -> color.
  void ForwardColor(Batch* batch) const {
    const LayerLayout& hidden = layout_.color_hidden;
    const LayerLayout& output = layout_.color_output;
    const uint32_t width = hidden.num_outputs;
    const size_t n = batch->NumSamples();
    device_->Launch(DenseForwardKernel{batch->direction.data(),
                                       values_ + DirectionWeights(),
                                       values_ + hidden.biases,
                                       /*rows_per_bias=*/0,
                                       kDirectionWidth,
                                       width,
                                       width,
                                       Activation::kNone,
                                       batch->direction_hidden.data()},
                    batch->num_rays * width);
    device_->Launch(
        DenseForwardKernel{batch->geometry.data(),
                           values_ + hidden.weights,
                           batch->direction_hidden.data(),
                           static_cast<uint32_t>(batch->samples_per_ray),
                           kGeometryWidth,
                           width,
                           width,
                           Activation::kRectify,
                           batch->color_hidden.data()},
        n * width);
    device_->Launch(DenseForwardKernel{batch->color_hidden.data(),
                                       values_ + output.weights,
                                       values_ + output.biases,
                                       /*rows_per_bias=*/0,
                                       width,
                                       kNumColorChannels,
                                       kColorOutputWidth,
                                       Activation::kSigmoid,
                                       batch->color.data()},
                    n * kNumColorChannels);
  }

  // d_color and d_raw_density -> d_encoding. Adds the gradient by the
  // parameters to `gradient`.
  void Backward(Batch* batch, float* gradient) const {
    const size_t n = batch->NumSamples();
    const size_t num_parameters = layout_.num_network_parameters;
    const size_t num_chunks = DenseBackwardWeightsKernel::NumChunks(n);
    // Not every chunk has rows of every layer.
    batch->d_network.Clear(num_chunks * num_parameters);
    BackwardColor(batch);
    device_->Launch(AddToColumnKernel{batch->d_raw_density.data(),
                                      kGeometryWidth,
                                      batch->d_geometry.data()},
                    n);
    BackwardDensity(batch);
    device_->Launch(
        SumChunksKernel{
            batch->d_network.data(), num_chunks, num_parameters, gradient},
        num_parameters);
  }

 private:
  // Where the rows of the colour layer that read the direction begin.
  size_t DirectionWeights() const {
    return layout_.color_hidden.weights + static_cast<size_t>(kGeometryWidth) *
                                              layout_.color_hidden.num_outputs;
  }

  void Forward(const LayerLayout& layer,
               const float* x,
               const size_t num_rows,
               const Activation activation,
               float* y) const {
    const uint32_t num_outputs = layer.num_outputs;
    device_->Launch(DenseForwardKernel{x,
                                       values_ + layer.weights,
                                       values_ + layer.biases,
                                       /*rows_per_bias=*/0,
                                       static_cast<uint32_t>(layer.num_inputs),
                                       num_outputs,
                                       num_outputs,
                                       activation,
                                       y},
                    num_rows * num_outputs);
  }

  // A block of a layer's weights: its first row, and the columns in use.
  struct Block {
    size_t offset;  // into the parameters
    uint32_t num_inputs;
    uint32_t num_outputs;
    uint32_t stride;
  };

  // By the block's weights, and by the biases if they follow.
  void BackwardWeights(const Block& block,
                       const float* x,
                       const float* dy,
                       const size_t num_rows,
                       const bool has_biases,
                       Batch* batch) const {
    const DenseBackwardWeightsKernel kernel{
        x,
        dy,
        num_rows,
        block.num_inputs,
        block.num_outputs,
        block.stride,
        has_biases,
        layout_.num_network_parameters,
        batch->d_network.data() + block.offset};
    device_->Launch(kernel, kernel.NumCalls());
  }

  void BackwardInput(const Block& block,
                     const float* dy,
                     const float* activation,
                     const size_t num_rows,
                     float* dx,
                     Batch* batch) const {
    device_->Launch(TransposeKernel{values_ + block.offset,
                                    block.num_inputs,
                                    block.stride,
                                    batch->transposed.data()},
                    static_cast<size_t>(block.num_inputs) * block.num_outputs);
    device_->Launch(DenseBackwardInputKernel{dy,
                                             batch->transposed.data(),
                                             activation,
                                             block.num_inputs,
                                             block.num_outputs,
                                             dx},
                    num_rows * block.num_inputs);
  }

  // d_color -> d_geometry.
  void BackwardColor(Batch* batch) const {
    const size_t n = batch->NumSamples();
    const uint32_t width = layout_.color_hidden.num_outputs;
    const Block output = {layout_.color_output.weights,
                          width,
                          kNumColorChannels,
                          kColorOutputWidth};
    BackwardWeights(output,
                    batch->color_hidden.data(),
                    batch->d_color.data(),
                    n,
                    /*has_biases=*/true,
                    batch);
    BackwardInput(output,
                  batch->d_color.data(),
                  batch->color_hidden.data(),
                  n,
                  batch->d_hidden.data(),
                  batch);
    const Block geometry = {
        layout_.color_hidden.weights, kGeometryWidth, width, width};
    BackwardWeights(geometry,
                    batch->geometry.data(),
                    batch->d_hidden.data(),
                    n,
                    /*has_biases=*/false,
                    batch);
    device_->Launch(
        SumGroupsKernel{batch->d_hidden.data(),
                        static_cast<uint32_t>(batch->samples_per_ray),
                        width,
                        batch->d_direction_hidden.data()},
        batch->num_rays * width);
    BackwardWeights({DirectionWeights(), kDirectionWidth, width, width},
                    batch->direction.data(),
                    batch->d_direction_hidden.data(),
                    batch->num_rays,
                    /*has_biases=*/true,
                    batch);
    BackwardInput(geometry,
                  batch->d_hidden.data(),
                  nullptr,
                  n,
                  batch->d_geometry.data(),
                  batch);
  }

  // d_geometry -> d_encoding.
  void BackwardDensity(Batch* batch) const {
    const size_t n = batch->NumSamples();
    const uint32_t width = layout_.density_hidden.num_outputs;
    const Block output = {
        layout_.density_output.weights, width, kGeometryWidth, kGeometryWidth};
    BackwardWeights(output,
                    batch->density_hidden.data(),
                    batch->d_geometry.data(),
                    n,
                    /*has_biases=*/true,
                    batch);
    BackwardInput(output,
                  batch->d_geometry.data(),
                  batch->density_hidden.data(),
                  n,
                  batch->d_hidden.data(),
                  batch);
    const Block hidden = {
        layout_.density_hidden.weights,
        static_cast<uint32_t>(layout_.density_hidden.num_inputs),
        width,
        width};
    BackwardWeights(hidden,
                    batch->encoding.data(),
                    batch->d_hidden.data(),
                    n,
                    /*has_biases=*/true,
                    batch);
    BackwardInput(hidden,
                  batch->d_hidden.data(),
                  nullptr,
                  n,
                  batch->d_encoding.data(),
                  batch);
  }

  const FieldLayout& layout_;
  const float* const values_;
  Device* const device_;
};

}  // namespace structnerf
