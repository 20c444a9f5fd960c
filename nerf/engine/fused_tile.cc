#include "nerf/engine/fused_tile.h"

#include "nerf/engine/tile_sampling.h"
#include "nerf/kernels/color_compositing.h"

#include <algorithm>

namespace structnerf {

FusedTile::FusedTile(const FieldLayout& layout,
                     const RaySamplingParameters& sampling,
                     const float min_color_weight,
                     const int thread)
    : sampling_(sampling),
      min_color_weight_(min_color_weight),
      thread_(thread),
      num_harmonics_(layout.num_harmonics),
      network_(layout, kMaxTileRays, kMaxTileRays * sampling.num_samples),
      edges_(kMaxTileRays * (sampling.num_samples + 1)),
      ray_color_(kMaxTileRays * kRayColorWidth),
      d_ray_color_(kMaxTileRays * kRayColorWidth) {
  const size_t num_samples = kMaxTileRays * sampling.num_samples;
  for (AlignedBuffer<float>& position : position_) {
    position.Allocate(num_samples + 16);
  }
  for (AlignedBuffer<float>* buffer :
       {&tau_, &transmittance_, &weight_, &z_, &d_weight_color_, &d_weight_}) {
    buffer->Allocate(num_samples);
  }
  active_samples_.Allocate(num_samples);
  active_rays_.Allocate(num_samples);
}

CompositeInputs FusedTile::MakeCompositeInputs(const RayTile& rays) const {
  CompositeInputs inputs;
  inputs.num_rays = rays.num_rays;
  inputs.num_samples = sampling_.num_samples;
  inputs.raw_density = network_.geometry.data();
  inputs.raw_density_stride = kGeometryWidth;
  inputs.edges = edges_.data();
  inputs.ray_length = rays.direction_norm.data();
  return inputs;
}

CompositeSamples FusedTile::MakeCompositeSamples() {
  return {tau_.data(), transmittance_.data(), weight_.data(), z_.data()};
}

void FusedTile::Forward(const FusedField& field,
                        const RayTile& rays,
                        Random* random,
                        const bool with_color,
                        RayOutputs* outputs) {
  num_samples_ = static_cast<size_t>(rays.num_rays) * sampling_.num_samples;
  clock_.Start();
  SampleTile(rays,
             field.cache,
             sampling_,
             random,
             edges_.data(),
             position_[0].data(),
             position_[1].data(),
             position_[2].data());
  clock_.Stop(EngineStage::kRays);
  field.grid.Encode(position_[0].data(),
                    position_[1].data(),
                    position_[2].data(),
                    num_samples_,
                    field.level_weights,
                    thread_,
                    network_.encoding.data());
  clock_.Stop(EngineStage::kEncode);
  field.network.ForwardDensity(num_samples_, &network_);
  clock_.Stop(EngineStage::kDensityNetwork);
  CompositeForward(MakeCompositeInputs(rays),
                   MakeCompositeSamples(),
                   outputs->depth.data(),
                   outputs->depth_variance.data(),
                   outputs->opacity.data());
  clock_.Stop(EngineStage::kComposite);
  if (with_color) {
    ForwardColor(field, rays, outputs);
    clock_.Stop(EngineStage::kColorNetwork);
  }
}

void FusedTile::ForwardColor(const FusedField& field,
                             const RayTile& rays,
                             RayOutputs* outputs) {
  num_active_ = 0;
  const uint32_t n = sampling_.num_samples;
  for (uint32_t ray = 0; ray < static_cast<uint32_t>(rays.num_rays); ++ray) {
    for (uint32_t s = ray * n; s < (ray + 1) * n; ++s) {
      active_samples_[num_active_] = s;
      active_rays_[num_active_] = ray;
      num_active_ += weight_[s] >= min_color_weight_;
    }
    EncodeDirection(rays,
                    ray,
                    num_harmonics_,
                    network_.direction.data() + ray * kDirectionWidth);
  }
  field.network.ForwardColor(
      {active_samples_.data(), active_rays_.data(), num_active_},
      rays.num_rays,
      &network_);
  CompositeColor({num_active_,
                  active_samples_.data(),
                  active_rays_.data(),
                  network_.color.data(),
                  weight_.data()},
                 rays.num_rays,
                 ray_color_.data());
  for (int ray = 0; ray < rays.num_rays; ++ray) {
    for (int c = 0; c < 3; ++c) {
      outputs->color[c][ray] = ray_color_[ray * kRayColorWidth + c];
    }
  }
}

RaySamples FusedTile::Samples() const {
  return {sampling_.num_samples, edges_.data(), weight_.data()};
}

float* FusedTile::ClearedWeightGradient() {
  std::fill(d_weight_.data(), d_weight_.data() + num_samples_, 0.0f);
  return d_weight_.data();
}

void FusedTile::Backward(const FusedField& field,
                         const RayTile& rays,
                         const RayOutputs& outputs,
                         const RayGradients& gradients,
                         const float* d_weight,
                         float* network_gradient) {
  clock_.Start();
  for (int ray = 0; ray < rays.num_rays; ++ray) {
    for (int c = 0; c < 3; ++c) {
      d_ray_color_[ray * kRayColorWidth + c] = gradients.d_color[c][ray];
    }
  }
  // Samples that are not active neither gain nor lose from colour.
  std::fill(
      d_weight_color_.data(), d_weight_color_.data() + num_samples_, 0.0f);
  CompositeColorBackward({num_active_,
                          active_samples_.data(),
                          active_rays_.data(),
                          network_.color.data(),
                          weight_.data()},
                         ray_color_.data(),
                         d_ray_color_.data(),
                         d_weight_color_.data(),
                         network_.d_color.data());
  if (d_weight != nullptr) {
    for (size_t s = 0; s < num_samples_; ++s) {
      d_weight_color_[s] += d_weight[s];
    }
  }
  CompositeGradients composite_gradients;
  composite_gradients.depth = outputs.depth.data();
  composite_gradients.d_depth = gradients.d_depth.data();
  composite_gradients.d_opacity = gradients.d_opacity.data();
  composite_gradients.pull = gradients.pull.data();
  composite_gradients.pull_z = gradients.pull_z.data();
  composite_gradients.d_weight_color = d_weight_color_.data();
  CompositeBackward(MakeCompositeInputs(rays),
                    MakeCompositeSamples(),
                    composite_gradients,
                    network_.d_raw_density.data());
  clock_.Stop(EngineStage::kComposite);
  field.network.Backward(
      {active_samples_.data(), active_rays_.data(), num_active_},
      rays.num_rays,
      num_samples_,
      &network_,
      network_gradient);
  clock_.Stop(EngineStage::kBackward);
}

void FusedTile::EvaluateDensity(const FusedField& field,
                                const float* x,
                                const float* y,
                                const float* z,
                                const size_t num_points,
                                float* raw_density) {
  field.grid.Encode(x,
                    y,
                    z,
                    num_points,
                    field.level_weights,
                    thread_,
                    network_.encoding.data());
  field.network.ForwardDensity(num_points, &network_);
  for (size_t i = 0; i < num_points; ++i) {
    raw_density[i] = network_.geometry[i * kGeometryWidth];
  }
}

void FusedTile::CopyRawDensity(float* raw_density) const {
  for (size_t s = 0; s < num_samples_; ++s) {
    raw_density[s] = network_.geometry[s * kGeometryWidth];
  }
}

}  // namespace structnerf
