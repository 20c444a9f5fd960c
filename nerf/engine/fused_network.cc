#include "nerf/engine/fused_network.h"

#include "nerf/kernels/dense_layer.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace structnerf {
namespace {

void Transpose(const LayerLayout& layer, const float* from, float* to) {
  for (int i = 0; i < layer.num_inputs; ++i) {
    for (int j = 0; j < layer.num_outputs; ++j) {
      to[layer.weights + j * layer.num_inputs + i] =
          from[layer.weights + i * layer.num_outputs + j];
    }
  }
}

}  // namespace

FusedNetwork::Buffers::Buffers(const FieldLayout& layout, const size_t capacity)
    : encoding(capacity * layout.encoding_width),
      density_hidden(capacity * layout.hidden_width),
      geometry(capacity * kGeometryWidth),
      color_input(capacity * kColorInputWidth),
      color_hidden(capacity * layout.hidden_width),
      color(capacity * kColorOutputWidth),
      d_color(capacity * kColorOutputWidth),
      d_raw_density(capacity * kGeometryWidth),
      d_color_input(capacity * kColorInputWidth),
      d_hidden(capacity * layout.hidden_width),
      d_geometry(capacity * kGeometryWidth) {}

FusedNetwork::FusedNetwork(const FieldLayout& layout)
    : layout_(layout),
      parameters_(layout.num_network_parameters),
      transposed_(layout.num_network_parameters) {}

void FusedNetwork::SetParameters(const float* network) {
  std::copy(
      network, network + layout_.num_network_parameters, parameters_.data());
  for (const LayerLayout* layer : {&layout_.density_hidden,
                                   &layout_.density_output,
                                   &layout_.color_hidden,
                                   &layout_.color_output}) {
    Transpose(*layer, network, transposed_.data());
  }
}

void FusedNetwork::ForwardDensity(const size_t num_samples,
                                  Buffers* buffers) const {
  const LayerLayout& hidden = layout_.density_hidden;
  const LayerLayout& output = layout_.density_output;
  DenseForward(buffers->encoding.data(),
               parameters_.data() + hidden.weights,
               parameters_.data() + hidden.biases,
               num_samples,
               hidden.num_inputs,
               hidden.num_outputs,
               /*rectify=*/true,
               buffers->density_hidden.data());
  DenseForward(buffers->density_hidden.data(),
               parameters_.data() + output.weights,
               parameters_.data() + output.biases,
               num_samples,
               output.num_inputs,
               output.num_outputs,
               /*rectify=*/false,
               buffers->geometry.data());
}

void FusedNetwork::ForwardColor(const uint32_t* active,
                                const size_t num_active,
                                const size_t samples_per_ray,
                                const float* direction,
                                Buffers* buffers) const {
  for (size_t a = 0; a < num_active; ++a) {
    float* const input = buffers->color_input.data() + a * kColorInputWidth;
    std::memcpy(input,
                buffers->geometry.data() + active[a] * kGeometryWidth,
                kGeometryWidth * sizeof(float));
    std::memcpy(input + kGeometryWidth,
                direction + active[a] / samples_per_ray * kDirectionWidth,
                kDirectionWidth * sizeof(float));
  }
  const LayerLayout& hidden = layout_.color_hidden;
  const LayerLayout& output = layout_.color_output;
  DenseForward(buffers->color_input.data(),
               parameters_.data() + hidden.weights,
               parameters_.data() + hidden.biases,
               num_active,
               hidden.num_inputs,
               hidden.num_outputs,
               /*rectify=*/true,
               buffers->color_hidden.data());
  DenseForward(buffers->color_hidden.data(),
               parameters_.data() + output.weights,
               parameters_.data() + output.biases,
               num_active,
               output.num_inputs,
               output.num_outputs,
               /*rectify=*/false,
               buffers->color.data());
  for (size_t a = 0; a < num_active; ++a) {
    float* const color = buffers->color.data() + a * kColorOutputWidth;
    for (int c = 0; c < 3; ++c) {
      color[c] = 1.0f / (1.0f + std::exp(-color[c]));
    }
  }
}

void FusedNetwork::BackwardColor(const uint32_t* active,
                                 const size_t num_active,
                                 const size_t num_samples,
                                 Buffers* buffers,
                                 float* gradient) const {
  const LayerLayout& hidden = layout_.color_hidden;
  const LayerLayout& output = layout_.color_output;
  DenseBackwardParameters(buffers->color_hidden.data(),
                          buffers->d_color.data(),
                          num_active,
                          output.num_inputs,
                          output.num_outputs,
                          gradient + output.weights,
                          gradient + output.biases);
  DenseBackwardInput(buffers->d_color.data(),
                     transposed_.data() + output.weights,
                     buffers->color_hidden.data(),
                     num_active,
                     output.num_inputs,
                     output.num_outputs,
                     buffers->d_hidden.data());
  DenseBackwardParameters(buffers->color_input.data(),
                          buffers->d_hidden.data(),
                          num_active,
                          hidden.num_inputs,
                          hidden.num_outputs,
                          gradient + hidden.weights,
                          gradient + hidden.biases);
  DenseBackwardInput(buffers->d_hidden.data(),
                     transposed_.data() + hidden.weights,
                     nullptr,
                     num_active,
                     hidden.num_inputs,
                     hidden.num_outputs,
                     buffers->d_color_input.data());
  std::fill(buffers->d_geometry.data(),
            buffers->d_geometry.data() + num_samples * kGeometryWidth,
            0.0f);
  for (size_t a = 0; a < num_active; ++a) {
    std::memcpy(buffers->d_geometry.data() + active[a] * kGeometryWidth,
                buffers->d_color_input.data() + a * kColorInputWidth,
                kGeometryWidth * sizeof(float));
  }
}

void FusedNetwork::BackwardDensity(const size_t num_samples,
                                   Buffers* buffers,
                                   float* gradient,
                                   float* d_encoding) const {
  for (size_t s = 0; s < num_samples; ++s) {
    buffers->d_geometry[s * kGeometryWidth] +=
        buffers->d_raw_density[s * kGeometryWidth];
  }
  const LayerLayout& hidden = layout_.density_hidden;
  const LayerLayout& output = layout_.density_output;
  DenseBackwardParameters(buffers->density_hidden.data(),
                          buffers->d_geometry.data(),
                          num_samples,
                          output.num_inputs,
                          output.num_outputs,
                          gradient + output.weights,
                          gradient + output.biases);
  DenseBackwardInput(buffers->d_geometry.data(),
                     transposed_.data() + output.weights,
                     buffers->density_hidden.data(),
                     num_samples,
                     output.num_inputs,
                     output.num_outputs,
                     buffers->d_hidden.data());
  DenseBackwardParameters(buffers->encoding.data(),
                          buffers->d_hidden.data(),
                          num_samples,
                          hidden.num_inputs,
                          hidden.num_outputs,
                          gradient + hidden.weights,
                          gradient + hidden.biases);
  DenseBackwardInput(buffers->d_hidden.data(),
                     transposed_.data() + hidden.weights,
                     nullptr,
                     num_samples,
                     hidden.num_inputs,
                     hidden.num_outputs,
                     d_encoding);
}

}  // namespace structnerf
