#pragma once

#include "nerf/cuda/adam-inl.h"
#include "nerf/cuda/compositing-inl.h"
#include "nerf/cuda/device_batch.h"
#include "nerf/cuda/device_buffer.h"
#include "nerf/cuda/device_network-inl.h"
#include "nerf/cuda/grid_encoding-inl.h"
#include "nerf/field/field_layout.h"
#include "nerf/kernels/adam.h"
#include "nerf/kernels/grid_gradient.h"
#include "nerf/util/state_stream.h"

#include <stdexcept>
#include <vector>

namespace structnerf {

static_assert(kDeviceFeatures == kGridFeatures);

// The field of the fused engine in the memory of a device, in single
// precision: forward, backward, and the step of the optimiser.
template <class Device>
class DeviceField {
 public:
  using Batch = DeviceBatch<Device>;

  DeviceField(const FieldLayout& layout,
              const float min_color_weight,
              Device* device)
      : layout_(layout),
        min_color_weight_(min_color_weight),
        device_(device),
        grid_(layout.num_grid_entries * kGridFeatures, device),
        network_(layout.num_network_parameters, device),
        networks_(layout, network_.value.data(), device),
        not_finite_(1, device) {
    if (layout.levels.size() > kMaxDeviceLevels) {
      throw std::invalid_argument("num_levels is too large for the device");
    }
  }

  // Raw density of the batch's samples, from their positions.
  void ForwardDensity(const std::vector<float>& level_weights,
                      Batch* batch) const {
    const DeviceGrid grid = MakeGrid(level_weights);
    device_->Launch(
        GridEncodeKernel{grid,
                         batch->Points(),
                         grid_.value.data(),
                         static_cast<uint32_t>(layout_.encoding_width),
                         batch->encoding.data()},
        batch->NumSamples() * grid.num_levels);
    networks_.ForwardDensity(batch);
  }

  // Depth, and colour if asked for, of the batch's rays, after ForwardDensity.
  void ForwardRays(const bool with_color, Batch* batch) const {
    device_->Launch(CompositeForwardKernel{batch->MakeCompositeInputs(),
                                           batch->MakeCompositeSamples(),
                                           batch->depth.data(),
                                           batch->depth_variance.data(),
                                           batch->opacity.data()},
                    batch->num_rays);
    if (with_color) {
      networks_.ForwardColor(batch);
      device_->Launch(
          CompositeColorKernel{Colors(*batch), batch->ray_color.data()},
          batch->num_rays);
    }
  }

  // Adds the gradient by the parameters, from batch->ray_gradients and
  // batch->d_weight, after ForwardDensity and ForwardRays with colour.
  void Backward(const std::vector<float>& level_weights, Batch* batch) {
    const size_t num_rays = batch->num_rays;
    const size_t n = batch->NumSamples();
    const float* const d_ray_color = batch->ray_gradients.data();
    const float* const d_rest = d_ray_color + num_rays * kNumColorChannels;
    device_->Launch(CompositeColorBackwardKernel{Colors(*batch),
                                                 batch->ray_color.data(),
                                                 d_ray_color,
                                                 batch->d_weight.data(),
                                                 batch->d_weight_color.data(),
                                                 batch->d_color.data()},
                    n);
    device_->Launch(CompositeBackwardKernel{batch->MakeCompositeInputs(),
                                            batch->MakeCompositeSamples(),
                                            {batch->depth.data(),
                                             d_rest,
                                             d_rest + num_rays,
                                             d_rest + 2 * num_rays,
                                             d_rest + 3 * num_rays,
                                             batch->d_weight_color.data()},
                                            batch->d_raw_density.data()},
                    num_rays);
    networks_.Backward(batch, network_.gradient.data());
    const uint32_t width = static_cast<uint32_t>(layout_.encoding_width);
    const uint32_t tile_points =
        static_cast<uint32_t>(kMaxTileRays * batch->samples_per_ray);
    batch->largest_of_tile.Clear(batch->NumTiles());
    device_->Launch(LargestGradientKernel{batch->d_encoding.data(),
                                          width,
                                          tile_points,
                                          batch->largest_gradient.data(),
                                          batch->largest_of_tile.data()},
                    n);
    const DeviceGrid grid = MakeGrid(level_weights);
    device_->Launch(GridBackwardKernel{grid,
                                       batch->Points(),
                                       batch->d_encoding.data(),
                                       width,
                                       batch->largest_gradient.data(),
                                       batch->largest_of_tile.data(),
                                       tile_points,
                                       kNegligibleGradient,
                                       grid_.gradient.data()},
                    n * grid.num_levels);
  }

  // See RenderEngine::Update. The rate of the network includes the correction
  // of its bias.
  bool Update(const float grid_learning_rate,
              const float network_learning_rate) {
    const size_t num_parameters = layout_.num_network_parameters;
    not_finite_.Clear(1);
    device_->Launch(CheckGradientKernel{Adam(network_learning_rate),
                                        network_.gradient.data(),
                                        not_finite_.data()},
                    num_parameters);
    device_->Launch(AdamKernel{Adam(network_learning_rate),
                               network_.Parameters(),
                               not_finite_.data()},
                    num_parameters);
    device_->Launch(AdamGridKernel{Adam(grid_learning_rate),
                                   grid_.Parameters(),
                                   kDeviceFeatures,
                                   not_finite_.data()},
                    layout_.num_grid_entries);
    return not_finite_.Download(1)[0] == 0;
  }

  void SetParameters(const FieldParameters& parameters) {
    grid_.value.Upload(parameters.grid);
    network_.value.Upload(parameters.network);
  }

  FieldParameters Parameters() const {
    return {grid_.value.Download(grid_.Size()),
            network_.value.Download(network_.Size())};
  }

  FieldParameters Gradients() const {
    return {grid_.gradient.Download(grid_.Size()),
            network_.gradient.Download(network_.Size())};
  }

  void ClearMoments() {
    for (Learned* learned : {&grid_, &network_}) {
      learned->first_moment.Clear(learned->Size());
      learned->root_second_moment.Clear(learned->Size());
    }
  }

  void SaveState(StateWriter* writer) const {
    for (const Learned* learned : {&grid_, &network_}) {
      for (const Buffer* buffer : {&learned->value,
                                   &learned->first_moment,
                                   &learned->root_second_moment}) {
        writer->WriteArray(buffer->Download(learned->Size()));
      }
    }
  }

  void LoadState(StateReader* reader) {
    for (Learned* learned : {&grid_, &network_}) {
      for (Buffer* buffer : {&learned->value,
                             &learned->first_moment,
                             &learned->root_second_moment}) {
        const auto values = reader->ReadArray<std::vector<float>>();
        if (values.size() != learned->Size()) {
          throw std::runtime_error("the state is that of another field");
        }
        buffer->Upload(values);
      }
    }
  }

 private:
  using Buffer = DeviceBuffer<float, Device>;

  // Parameters, all arrays of the same size.
  struct Learned {
    Learned(const size_t size, Device* device)
        : value(size, device),
          gradient(size, device),
          first_moment(size, device),
          root_second_moment(size, device) {}

    size_t Size() const { return value.size(); }
    DeviceParameters Parameters() {
      return {value.data(),
              gradient.data(),
              first_moment.data(),
              root_second_moment.data()};
    }

    Buffer value;
    Buffer gradient;
    Buffer first_moment;
    Buffer root_second_moment;
  };

  DeviceGrid MakeGrid(const std::vector<float>& level_weights) const {
    DeviceGrid grid = {};
    grid.num_levels = static_cast<uint32_t>(layout_.levels.size());
    for (uint32_t i = 0; i < grid.num_levels; ++i) {
      const GridLevel& level = layout_.levels[i];
      grid.levels[i] = {
          level.cells_per_unit,
          {level.vertices[0], level.vertices[1], level.vertices[2]},
          level.hashed,
          level.num_entries,
          level.first_entry,
          level_weights.empty() ? 1.0f : level_weights[i]};
    }
    return grid;
  }

  static DeviceAdam Adam(const float learning_rate) {
    const AdamStep step;
    return {learning_rate, step.beta1, step.beta2, step.epsilon, kMaxGradient};
  }

  DeviceColors Colors(const Batch& batch) const {
    return {static_cast<uint32_t>(batch.samples_per_ray),
            batch.weight.data(),
            batch.color.data(),
            min_color_weight_};
  }

  const FieldLayout& layout_;
  const float min_color_weight_;
  Device* const device_;
  Learned grid_;
  Learned network_;
  const DeviceNetwork<Device> networks_;
  DeviceBuffer<uint32_t, Device> not_finite_;
};

}  // namespace structnerf
