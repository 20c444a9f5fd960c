// Kernels against their twins on the CPU.

#include "nerf/kernels/adam.h"

#include "nerf/cuda/adam-inl.h"
#include "nerf/field/field_layout.h"
#include "tests/nerf/cuda/test_devices.h"
#include "tests/nerf/random_values.h"

#include <cmath>
#include <limits>
#include <vector>

namespace structnerf {
namespace {

template <class Device>
class AdamKernelsTest : public DeviceTest<Device> {};

TYPED_TEST_SUITE(AdamKernelsTest, TestDevices);

TYPED_TEST(AdamKernelsTest, Adam) {
  constexpr size_t kEntries = 50;
  constexpr size_t kCount = kEntries * kGridFeatures;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  AdamStep step;
  step.learning_rate = 0.01f;
  const DeviceAdam adam = {
      step.learning_rate, step.beta1, step.beta2, step.epsilon, kMaxGradient};
  auto value = RandomValues(kCount, -1, 1, 1);
  std::vector<float> first(kCount);
  std::vector<float> root_second(kCount);
  const auto value_d = this->Upload(value);
  const auto gradient_d = this->Upload(first);
  const auto first_d = this->Upload(first);
  const auto root_second_d = this->Upload(root_second);
  const DeviceParameters parameters = {value_d->data(),
                                       gradient_d->data(),
                                       first_d->data(),
                                       root_second_d->data()};
  DeviceBuffer<uint32_t, TypeParam> not_finite(1, this->device_.get());
  for (uint64_t round = 0; round < 6; ++round) {
    const float scale = std::pow(10.0f, 6.0f * round - 20);
    std::vector<float> gradient =
        RandomValues(kCount, -scale, scale, 10 + round);
    gradient[0] = 0;
    gradient_d->Upload(gradient);
    if (round % 2 == 0) {
      this->device_->Launch(
          AdamGridKernel{adam, parameters, kGridFeatures, not_finite.data()},
          kEntries);
    } else {
      this->device_->Launch(
          CheckGradientKernel{adam, gradient_d->data(), not_finite.data()},
          kCount);
      this->device_->Launch(AdamKernel{adam, parameters, not_finite.data()},
                            kCount);
    }
    AdamUpdate(step,
               kCount,
               gradient.data(),
               first.data(),
               root_second.data(),
               value.data());
    this->ExpectNear(value_d->Download(kCount), value, 1e-6);
    EXPECT_EQ(gradient_d->Download(kCount), std::vector<float>(kCount));
  }
  EXPECT_EQ(not_finite.Download(1)[0], 0u);

  // One number is not finite: of the grid, its entry stays, of others, all.
  const std::vector<float> before = value_d->Download(kCount);
  for (const float bad : {nan, std::numeric_limits<float>::infinity(), 1e18f}) {
    std::vector<float> gradient(kCount, 0.0f);
    gradient[5] = bad;
    gradient[20] = 1;
    gradient_d->Upload(gradient);
    this->device_->Launch(
        CheckGradientKernel{adam, gradient_d->data(), not_finite.data()},
        kCount);
    EXPECT_EQ(not_finite.Download(1)[0], 1u);
    this->device_->Launch(AdamKernel{adam, parameters, not_finite.data()},
                          kCount);
    EXPECT_EQ(value_d->Download(kCount), before);
    EXPECT_EQ(gradient_d->Download(kCount), std::vector<float>(kCount));
    not_finite.Clear(1);
  }
  std::vector<float> gradient(kCount, 0.0f);
  gradient[5] = nan;
  gradient[20] = 1;
  gradient_d->Upload(gradient);
  this->device_->Launch(
      AdamGridKernel{adam, parameters, kGridFeatures, not_finite.data()},
      kEntries);
  EXPECT_EQ(not_finite.Download(1)[0], 1u);
  const std::vector<float> after = value_d->Download(kCount);
  EXPECT_EQ(after[5], before[5]);
  EXPECT_NE(after[20], before[20]);
  EXPECT_EQ(after[8], before[8]);  // no gradient, no step
  EXPECT_EQ(gradient_d->Download(kCount), std::vector<float>(kCount));
}

}  // namespace
}  // namespace structnerf
