#include "nerf/engine/fused_network.h"

#include "nerf/kernels/dense_layer.h"

#include <algorithm>
#include <cstring>

namespace structnerf {
namespace {

// Colour channels among the kColorOutputWidth columns.
constexpr size_t kNumChannels = 3;

// Samples that go through both density layers at a time; their activations then
// stay in the first-level cache.
constexpr size_t kChunk = 128;

void Transpose(const float* from,
               const int num_rows,
               const int num_cols,
               float* to) {
  for (int row = 0; row < num_rows; ++row) {
    for (int col = 0; col < num_cols; ++col) {
      to[col * num_rows + row] = from[row * num_cols + col];
    }
  }
}

// Where the rows of the colour layer's weights that read the direction begin.
size_t DirectionWeights(const LayerLayout& color_hidden) {
  return color_hidden.weights +
         static_cast<size_t>(kGeometryWidth) * color_hidden.num_outputs;
}

}  // namespace

FusedNetwork::Buffers::Buffers(const FieldLayout& layout,
                               const size_t num_rays,
                               const size_t num_samples)
    : encoding(num_samples * layout.encoding_width),
      density_hidden(num_samples * layout.hidden_width),
      geometry(num_samples * kGeometryWidth),
      direction(num_rays * kDirectionWidth),
      direction_hidden(num_rays * layout.hidden_width),
      color_geometry(num_samples * kGeometryWidth),
      color_hidden(num_samples * layout.hidden_width),
      color(num_samples * kColorOutputWidth),
      d_color(num_samples * kColorOutputWidth),
      d_raw_density(num_samples),
      d_encoding(num_samples * layout.encoding_width),
      d_color_geometry(num_samples * kGeometryWidth),
      d_color_output_weights(kNumChannels * layout.hidden_width),
      d_direction_hidden(num_rays * layout.hidden_width),
      d_hidden(num_samples * layout.hidden_width),
      d_geometry(num_samples * kGeometryWidth) {}

FusedNetwork::FusedNetwork(const FieldLayout& layout)
    : layout_(layout),
      parameters_(layout.num_network_parameters),
      transposed_(layout.num_network_parameters) {}

void FusedNetwork::SetParameters(const float* network) {
  std::copy(
      network, network + layout_.num_network_parameters, parameters_.data());
  const auto transpose = [&](const LayerLayout& layer, const int num_inputs) {
    Transpose(network + layer.weights,
              num_inputs,
              layer.num_outputs,
              transposed_.data() + layer.weights);
  };
  transpose(layout_.density_hidden, layout_.density_hidden.num_inputs);
  transpose(layout_.density_output, layout_.density_output.num_inputs);
  // There is no gradient by the direction.
  transpose(layout_.color_hidden, kGeometryWidth);
  transpose(layout_.color_output, layout_.color_output.num_inputs);
}

void FusedNetwork::ForwardDensity(const size_t num_samples,
                                  Buffers* buffers) const {
  const LayerLayout& hidden = layout_.density_hidden;
  const LayerLayout& output = layout_.density_output;
  for (size_t begin = 0; begin < num_samples; begin += kChunk) {
    const size_t size = std::min(kChunk, num_samples - begin);
    float* const hidden_rows =
        buffers->density_hidden.data() + begin * hidden.num_outputs;
    DenseForward(buffers->encoding.data() + begin * hidden.num_inputs,
                 parameters_.data() + hidden.weights,
                 parameters_.data() + hidden.biases,
                 nullptr,
                 size,
                 hidden.num_inputs,
                 hidden.num_outputs,
                 /*rectify=*/true,
                 hidden_rows);
    DenseForward(hidden_rows,
                 parameters_.data() + output.weights,
                 parameters_.data() + output.biases,
                 nullptr,
                 size,
                 output.num_inputs,
                 output.num_outputs,
                 /*rectify=*/false,
                 buffers->geometry.data() + begin * output.num_outputs);
  }
}

void FusedNetwork::ForwardColor(const ActiveSamples& active,
                                const size_t num_rays,
                                Buffers* buffers) const {
  const LayerLayout& hidden = layout_.color_hidden;
  const LayerLayout& output = layout_.color_output;
  DenseForward(buffers->direction.data(),
               parameters_.data() + DirectionWeights(hidden),
               parameters_.data() + hidden.biases,
               nullptr,
               num_rays,
               kDirectionWidth,
               hidden.num_outputs,
               /*rectify=*/false,
               buffers->direction_hidden.data());
  for (size_t a = 0; a < active.count; ++a) {
    std::memcpy(buffers->color_geometry.data() + a * kGeometryWidth,
                buffers->geometry.data() + active.samples[a] * kGeometryWidth,
                kGeometryWidth * sizeof(float));
  }
  DenseForward(buffers->color_geometry.data(),
               parameters_.data() + hidden.weights,
               buffers->direction_hidden.data(),
               active.rays,
               active.count,
               kGeometryWidth,
               hidden.num_outputs,
               /*rectify=*/true,
               buffers->color_hidden.data());
  DenseForward(buffers->color_hidden.data(),
               parameters_.data() + output.weights,
               parameters_.data() + output.biases,
               nullptr,
               active.count,
               output.num_inputs,
               output.num_outputs,
               /*rectify=*/false,
               buffers->color.data());
  Sigmoid(active.count * kColorOutputWidth, buffers->color.data());
}

void FusedNetwork::BackwardColor(const ActiveSamples& active,
                                 const size_t num_rays,
                                 Buffers* buffers,
                                 float* gradient) const {
  const LayerLayout& hidden = layout_.color_hidden;
  const LayerLayout& output = layout_.color_output;
  const size_t width = hidden.num_outputs;

  // Only three columns of the output have a gradient, so that of the weights is
  // formed transposed: its rows are then those columns.
  float* const d_weights = buffers->d_color_output_weights.data();
  std::fill(d_weights, d_weights + kNumChannels * width, 0.0f);
  DenseBackwardWeights(buffers->d_color.data(),
                       kColorOutputWidth,
                       buffers->color_hidden.data(),
                       active.count,
                       kNumChannels,
                       width,
                       d_weights);
  for (size_t k = 0; k < width; ++k) {
    for (size_t c = 0; c < kNumChannels; ++c) {
      gradient[output.weights + k * kColorOutputWidth + c] +=
          d_weights[c * width + k];
    }
  }
  DenseSumRows(buffers->d_color.data(),
               nullptr,
               active.count,
               kColorOutputWidth,
               gradient + output.biases);
  DenseBackwardInput(buffers->d_color.data(),
                     kColorOutputWidth,
                     transposed_.data() + output.weights,
                     buffers->color_hidden.data(),
                     active.count,
                     width,
                     kNumChannels,
                     buffers->d_hidden.data());

  DenseBackwardWeights(buffers->color_geometry.data(),
                       kGeometryWidth,
                       buffers->d_hidden.data(),
                       active.count,
                       kGeometryWidth,
                       width,
                       gradient + hidden.weights);
  float* const d_direction_hidden = buffers->d_direction_hidden.data();
  std::fill(d_direction_hidden, d_direction_hidden + num_rays * width, 0.0f);
  DenseSumRows(buffers->d_hidden.data(),
               active.rays,
               active.count,
               width,
               d_direction_hidden);
  DenseBackwardWeights(buffers->direction.data(),
                       kDirectionWidth,
                       d_direction_hidden,
                       num_rays,
                       kDirectionWidth,
                       width,
                       gradient + DirectionWeights(hidden));
  DenseSumRows(
      d_direction_hidden, nullptr, num_rays, width, gradient + hidden.biases);
  DenseBackwardInput(buffers->d_hidden.data(),
                     width,
                     transposed_.data() + hidden.weights,
                     nullptr,
                     active.count,
                     kGeometryWidth,
                     width,
                     buffers->d_color_geometry.data());
}

void FusedNetwork::Backward(const ActiveSamples& active,
                            const size_t num_rays,
                            const size_t num_samples,
                            Buffers* buffers,
                            float* gradient) const {
  BackwardColor(active, num_rays, buffers, gradient);
  float* const d_geometry = buffers->d_geometry.data();
  std::fill(d_geometry, d_geometry + num_samples * kGeometryWidth, 0.0f);
  for (size_t a = 0; a < active.count; ++a) {
    std::memcpy(d_geometry + active.samples[a] * kGeometryWidth,
                buffers->d_color_geometry.data() + a * kGeometryWidth,
                kGeometryWidth * sizeof(float));
  }
  for (size_t s = 0; s < num_samples; ++s) {
    d_geometry[s * kGeometryWidth] += buffers->d_raw_density[s];
  }

  const LayerLayout& hidden = layout_.density_hidden;
  const LayerLayout& output = layout_.density_output;
  for (size_t begin = 0; begin < num_samples; begin += kChunk) {
    const size_t size = std::min(kChunk, num_samples - begin);
    const float* const d_output = d_geometry + begin * kGeometryWidth;
    const float* const hidden_rows =
        buffers->density_hidden.data() + begin * hidden.num_outputs;
    float* const d_hidden = buffers->d_hidden.data();
    DenseBackwardWeights(hidden_rows,
                         hidden.num_outputs,
                         d_output,
                         size,
                         output.num_inputs,
                         output.num_outputs,
                         gradient + output.weights);
    DenseSumRows(
        d_output, nullptr, size, output.num_outputs, gradient + output.biases);
    DenseBackwardInput(d_output,
                       output.num_outputs,
                       transposed_.data() + output.weights,
                       hidden_rows,
                       size,
                       output.num_inputs,
                       output.num_outputs,
                       d_hidden);
    DenseBackwardWeights(buffers->encoding.data() + begin * hidden.num_inputs,
                         hidden.num_inputs,
                         d_hidden,
                         size,
                         hidden.num_inputs,
                         hidden.num_outputs,
                         gradient + hidden.weights);
    DenseSumRows(
        d_hidden, nullptr, size, hidden.num_outputs, gradient + hidden.biases);
    DenseBackwardInput(d_hidden,
                       hidden.num_outputs,
                       transposed_.data() + hidden.weights,
                       nullptr,
                       size,
                       hidden.num_inputs,
                       hidden.num_outputs,
                       buffers->d_encoding.data() + begin * hidden.num_inputs);
  }
}

}  // namespace structnerf
