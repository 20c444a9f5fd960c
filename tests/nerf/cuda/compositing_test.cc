// Kernels against their twins on the CPU.

#include "nerf/cuda/compositing-inl.h"
#include "nerf/field/field_layout.h"
#include "nerf/kernels/color_compositing.h"
#include "tests/nerf/cuda/test_devices.h"
#include "tests/nerf/random_values.h"

#include <algorithm>
#include <vector>

namespace structnerf {
namespace {

template <class Device>
class CompositingKernelsTest : public DeviceTest<Device> {};

TYPED_TEST_SUITE(CompositingKernelsTest, TestDevices);

// Rays from clear to opaque, with numbers beyond the clamps.
struct CompositeCase {
  static constexpr size_t kRays = 40;
  static constexpr size_t kSamples = 17;
  static constexpr size_t kCount = kRays * kSamples;

  CompositeCase() {
    for (size_t ray = 0; ray < kRays; ++ray) {
      const auto values = RandomValues(kSamples, -3, 3, ray);
      const auto steps = RandomValues(kSamples + 1, 0, 0.1f, 100 + ray);
      float edge = 0.1f;
      for (size_t i = 0; i <= kSamples; ++i) {
        edges.push_back(edge += i % 5 == 4 ? 0 : steps[i]);
      }
      for (size_t i = 0; i < kSamples; ++i) {
        raw_density.push_back(values[i] + 1.1f * (ray % 21) - 11);
        raw_density.push_back(77);  // of no use
      }
    }
  }

  template <class Floats>
  static CompositeInputs Inputs(const Floats& raw,
                                const Floats& edges,
                                const Floats& length) {
    return {kRays, kSamples, raw.data(), 2, edges.data(), length.data()};
  }

  std::vector<float> raw_density;
  std::vector<float> edges;
  std::vector<float> length = RandomValues(kRays, 1, 1.5f, 1);
};

TYPED_TEST(CompositingKernelsTest, Compositing) {
  using Case = CompositeCase;
  const Case test;
  std::vector<float> tau(Case::kCount);
  std::vector<float> transmittance(Case::kCount);
  std::vector<float> weight(Case::kCount);
  std::vector<float> z(Case::kCount);
  std::vector<float> depth(Case::kRays);
  std::vector<float> variance(Case::kRays);
  std::vector<float> opacity(Case::kRays);
  const CompositeInputs inputs =
      Case::Inputs(test.raw_density, test.edges, test.length);
  const CompositeSamples samples = {
      tau.data(), transmittance.data(), weight.data(), z.data()};
  CompositeForward(
      inputs, samples, depth.data(), variance.data(), opacity.data());

  const auto raw_d = this->Upload(test.raw_density);
  const auto edges_d = this->Upload(test.edges);
  const auto length_d = this->Upload(test.length);
  const auto tau_d = this->Upload(std::vector<float>(Case::kCount));
  const auto transmittance_d = this->Upload(std::vector<float>(Case::kCount));
  const auto weight_d = this->Upload(std::vector<float>(Case::kCount));
  const auto z_d = this->Upload(std::vector<float>(Case::kCount));
  const auto depth_d = this->Upload(std::vector<float>(Case::kRays));
  const auto variance_d = this->Upload(std::vector<float>(Case::kRays));
  const auto opacity_d = this->Upload(std::vector<float>(Case::kRays));
  const CompositeInputs inputs_d = Case::Inputs(*raw_d, *edges_d, *length_d);
  const CompositeSamples samples_d = {
      tau_d->data(), transmittance_d->data(), weight_d->data(), z_d->data()};
  this->device_->Launch(CompositeForwardKernel{inputs_d,
                                               samples_d,
                                               depth_d->data(),
                                               variance_d->data(),
                                               opacity_d->data()},
                        Case::kRays);
  this->ExpectNear(weight_d->Download(Case::kCount), weight, 1e-5);
  this->ExpectNear(z_d->Download(Case::kCount), z, 1e-5);
  this->ExpectNear(depth_d->Download(Case::kRays), depth, 1e-5);
  this->ExpectNear(variance_d->Download(Case::kRays), variance, 1e-5);
  this->ExpectNear(opacity_d->Download(Case::kRays), opacity, 1e-5);

  const auto d_weight = RandomValues(Case::kCount, -1, 1, 2);
  const auto d_depth = RandomValues(Case::kRays, -1, 1, 3);
  const auto d_opacity = RandomValues(Case::kRays, -1, 1, 4);
  auto pull = RandomValues(Case::kRays, 0, 1, 5);
  const auto pull_z = RandomValues(Case::kRays, 0.2f, 1, 6);
  for (size_t ray = 0; ray < Case::kRays; ray += 3) {
    pull[ray] = 0;
  }
  std::vector<float> expected(Case::kCount);
  CompositeBackward(inputs,
                    samples,
                    {depth.data(),
                     d_depth.data(),
                     d_opacity.data(),
                     pull.data(),
                     pull_z.data(),
                     d_weight.data()},
                    expected.data());
  const auto d_weight_d = this->Upload(d_weight);
  const auto d_depth_d = this->Upload(d_depth);
  const auto d_opacity_d = this->Upload(d_opacity);
  const auto pull_d = this->Upload(pull);
  const auto pull_z_d = this->Upload(pull_z);
  const auto d_raw_d = this->Upload(std::vector<float>(Case::kCount));
  this->device_->Launch(CompositeBackwardKernel{inputs_d,
                                                samples_d,
                                                {depth_d->data(),
                                                 d_depth_d->data(),
                                                 d_opacity_d->data(),
                                                 pull_d->data(),
                                                 pull_z_d->data(),
                                                 d_weight_d->data()},
                                                d_raw_d->data()},
                        Case::kRays);
  const std::vector<float> d_raw = d_raw_d->Download(Case::kCount);
  this->ExpectNear(d_raw, expected, 2e-5);
  size_t num_clamped[2] = {};
  for (size_t s = 0; s < Case::kCount; ++s) {
    const float raw = test.raw_density[2 * s];
    if (raw < kMinRawDensity || raw > kMaxRawDensity) {
      EXPECT_EQ(d_raw[s], 0);
      ++num_clamped[raw > 0];
    }
  }
  EXPECT_GT(num_clamped[0], 0u);
  EXPECT_GT(num_clamped[1], 0u);
}

TYPED_TEST(CompositingKernelsTest, ColorCompositing) {
  constexpr uint32_t kRays = 9;
  constexpr uint32_t kSamples = 12;
  constexpr uint32_t kCount = kRays * kSamples;
  constexpr float kMinWeight = 0.05f;
  auto weight = RandomValues(kCount, 0, 0.1f, 1);
  std::fill_n(weight.begin() + kSamples, kSamples, 0.0f);  // a ray without any
  const auto color = RandomValues(kCount * 3, 0, 1, 2);
  const auto d_ray_color = RandomValues(kRays * 3, -1, 1, 3);
  const auto more_d_weight = RandomValues(kCount, -1, 1, 4);

  std::vector<uint32_t> active_samples;
  std::vector<uint32_t> active_rays;
  std::vector<float> active_color;
  for (uint32_t s = 0; s < kCount; ++s) {
    if (weight[s] >= kMinWeight) {
      active_samples.push_back(s);
      active_rays.push_back(s / kSamples);
      active_color.resize(active_samples.size() * kColorOutputWidth);
      std::copy_n(
          color.begin() + s * 3, 3, active_color.end() - kColorOutputWidth);
    }
  }
  const ActiveColors active = {active_samples.size(),
                               active_samples.data(),
                               active_rays.data(),
                               active_color.data(),
                               weight.data()};
  std::vector<float> ray_color(kRays * kRayColorWidth);
  CompositeColor(active, kRays, ray_color.data());
  std::vector<float> d_padded(kRays * kRayColorWidth);
  for (uint32_t ray = 0; ray < kRays; ++ray) {
    std::copy_n(d_ray_color.begin() + ray * 3,
                3,
                d_padded.begin() + ray * kRayColorWidth);
  }
  std::vector<float> d_weight(kCount);
  std::vector<float> active_d_color(active_color.size());
  CompositeColorBackward(active,
                         ray_color.data(),
                         d_padded.data(),
                         d_weight.data(),
                         active_d_color.data());
  std::vector<float> d_color(kCount * 3);
  for (size_t a = 0; a < active.count; ++a) {
    std::copy_n(active_d_color.begin() + a * kColorOutputWidth,
                3,
                d_color.begin() + active_samples[a] * 3);
  }

  const auto weight_d = this->Upload(weight);
  const auto color_d = this->Upload(color);
  const auto ray_color_d = this->Upload(std::vector<float>(kRays * 4, 9.0f));
  const auto d_ray_color_d = this->Upload(d_ray_color);
  const auto more_d_weight_d = this->Upload(more_d_weight);
  const auto d_weight_d = this->Upload(std::vector<float>(kCount, 9.0f));
  const auto d_color_d = this->Upload(std::vector<float>(kCount * 3, 9.0f));
  const DeviceColors colors = {
      kSamples, weight_d->data(), color_d->data(), kMinWeight};
  this->device_->Launch(CompositeColorKernel{colors, ray_color_d->data()},
                        kRays);
  this->ExpectNear(ray_color_d->Download(kRays * 4), ray_color, 1e-5);
  EXPECT_EQ(ray_color_d->Download(8)[4], 0);
  this->device_->Launch(CompositeColorBackwardKernel{colors,
                                                     ray_color_d->data(),
                                                     d_ray_color_d->data(),
                                                     more_d_weight_d->data(),
                                                     d_weight_d->data(),
                                                     d_color_d->data()},
                        kCount);
  for (uint32_t s = 0; s < kCount; ++s) {
    d_weight[s] += more_d_weight[s];
  }
  this->ExpectNear(d_weight_d->Download(kCount), d_weight, 1e-5);
  this->ExpectNear(d_color_d->Download(kCount * 3), d_color, 1e-5);
}

}  // namespace
}  // namespace structnerf
