#pragma once

#include "nerf/cuda/dense_layer-inl.h"
#include "nerf/cuda/device_buffer.h"
#include "nerf/cuda/grid_encoding-inl.h"
#include "nerf/engine/ray_tile.h"
#include "nerf/field/field_layout.h"
#include "nerf/kernels/color_compositing.h"
#include "nerf/kernels/compositing.h"

#include <cstddef>

namespace structnerf {

constexpr size_t kNumColorChannels = 3;

// Derivatives by the results of each ray, in the order of RayGradients.
constexpr size_t kNumRayGradients = 7;

// Rays on the way through a field on a device: inputs, results, and what
// lies between forward and backward pass. Samples of a ray are neighbours.
template <class Device>
struct DeviceBatch {
  using Buffer = DeviceBuffer<float, Device>;

  explicit DeviceBatch(Device* device) : device(device) {}

  size_t NumSamples() const { return num_rays * samples_per_ray; }

  // Rays are taken by kMaxTileRays, no matter to which tiles they belong.
  size_t NumTiles() const {
    return (num_rays + kMaxTileRays - 1) / kMaxTileRays;
  }

  // Makes room for points, whose density is all that can be asked for. On
  // DeviceOutOfMemory, as for rays, the batch is of no further use.
  void ReservePoints(const FieldLayout& layout,
                     const size_t new_num_rays,
                     const size_t new_samples_per_ray) {
    num_rays = new_num_rays;
    samples_per_ray = new_samples_per_ray;
    const size_t n = NumSamples();
    for (Buffer& position : positions) {
      position.Reserve(n);
    }
    encoding.Reserve(n * layout.encoding_width);
    density_hidden.Reserve(n * layout.hidden_width);
    geometry.Reserve(n * kGeometryWidth);
    raw_density.Reserve(n);
  }

  // Makes room for rays with samples, so that nothing later needs more.
  void ReserveRays(const FieldLayout& layout,
                   const size_t new_num_rays,
                   const size_t new_samples_per_ray,
                   const bool with_gradient) {
    ReservePoints(layout, new_num_rays, new_samples_per_ray);
    const size_t n = NumSamples();
    edges.Reserve(n + num_rays);
    for (Buffer* per_ray : {&ray_length, &depth, &depth_variance, &opacity}) {
      per_ray->Reserve(num_rays);
    }
    direction.Reserve(num_rays * kDirectionWidth);
    direction_hidden.Reserve(num_rays * layout.hidden_width);
    ray_color.Reserve(num_rays * kRayColorWidth);
    for (Buffer* per_sample : {&tau, &transmittance, &weight, &z}) {
      per_sample->Reserve(n);
    }
    color_hidden.Reserve(n * layout.hidden_width);
    color.Reserve(n * kNumColorChannels);
    if (with_gradient) {
      ray_gradients.Reserve(num_rays * kNumRayGradients);
      for (Buffer* per_sample : {&d_weight, &d_weight_color, &d_raw_density}) {
        per_sample->Reserve(n);
      }
      d_color.Reserve(n * kNumColorChannels);
      d_hidden.Reserve(n * layout.hidden_width);
      d_direction_hidden.Reserve(num_rays * layout.hidden_width);
      d_geometry.Reserve(n * kGeometryWidth);
      d_encoding.Reserve(n * layout.encoding_width);
      largest_gradient.Reserve(n);
      largest_of_tile.Reserve(NumTiles());
      transposed.Reserve(layout.num_network_parameters);
      d_network.Reserve(DenseBackwardWeightsKernel::NumChunks(n) *
                        layout.num_network_parameters);
    }
  }

  DevicePoints Points() const {
    return {positions[0].data(), positions[1].data(), positions[2].data()};
  }
  CompositeInputs MakeCompositeInputs() const {
    return {num_rays,
            samples_per_ray,
            raw_density.data(),
            /*raw_density_stride=*/1,
            edges.data(),
            ray_length.data()};
  }
  CompositeSamples MakeCompositeSamples() {
    return {tau.data(), transmittance.data(), weight.data(), z.data()};
  }

  Device* const device;
  size_t num_rays = 0;
  size_t samples_per_ray = 0;

  // One row per sample unless said otherwise.
  Buffer positions[3] = {Buffer(device), Buffer(device), Buffer(device)};
  Buffer encoding{device};  // encoding_width, zero where there is no level
  Buffer density_hidden{device};  // hidden_width
  Buffer geometry{device};        // kGeometryWidth
  Buffer raw_density{device};     // the first column of geometry

  Buffer edges{device};             // rays x (samples_per_ray + 1)
  Buffer ray_length{device};        // rays
  Buffer direction{device};         // rays x kDirectionWidth
  Buffer direction_hidden{device};  // rays x hidden_width
  Buffer tau{device};               // see CompositeSamples
  Buffer transmittance{device};
  Buffer weight{device};
  Buffer z{device};
  Buffer color_hidden{device};    // hidden_width
  Buffer color{device};           // kNumColorChannels
  Buffer ray_color{device};       // rays x kRayColorWidth
  Buffer depth{device};           // rays
  Buffer depth_variance{device};  // rays
  Buffer opacity{device};         // rays

  Buffer ray_gradients{device};  // rays x kNumColorChannels by the colour, then
                                 // the others, one after the other
  Buffer d_weight{device};       // from the objective
  Buffer d_weight_color{device};
  Buffer d_raw_density{device};
  Buffer d_color{device};             // kNumColorChannels, before the sigmoid
  Buffer d_hidden{device};            // hidden_width, of either network
  Buffer d_direction_hidden{device};  // rays x hidden_width
  Buffer d_geometry{device};          // kGeometryWidth
  Buffer d_encoding{device};          // encoding_width
  Buffer largest_gradient{device};    // see LargestGradientKernel
  Buffer largest_of_tile{device};     // NumTiles()
  Buffer transposed{device};          // weights of one layer
  Buffer d_network{device};           // chunks x num_network_parameters
};

}  // namespace structnerf
