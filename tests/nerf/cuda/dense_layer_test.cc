// Kernels against their twins on the CPU.

#include "nerf/kernels/dense_layer.h"

#include "nerf/cuda/dense_layer-inl.h"
#include "tests/nerf/cuda/test_devices.h"
#include "tests/nerf/random_values.h"

#include <algorithm>
#include <vector>

namespace structnerf {
namespace {

// Beyond a chunk of the gradient by weights and a block of threads, and no
// multiple of either.
constexpr size_t kRows = 613;

template <class Device>
class DenseLayerKernelsTest : public DeviceTest<Device> {};

TYPED_TEST_SUITE(DenseLayerKernelsTest, TestDevices);

TYPED_TEST(DenseLayerKernelsTest, DenseForward) {
  constexpr uint32_t kInputs = 24;
  constexpr uint32_t kOutputs = 16;
  const auto x = RandomValues(kRows * kInputs, -1, 1, 1);
  const auto w = RandomValues(kInputs * kOutputs, -1, 1, 2);
  const auto b = RandomValues(kRows * kOutputs, -1, 1, 3);
  const auto x_d = this->Upload(x);
  const auto w_d = this->Upload(w);
  const auto b_d = this->Upload(b);
  const auto y_d = this->Upload(std::vector<float>(kRows * kOutputs, 9.0f));
  for (const uint32_t rows_per_bias : {0, 1, 7}) {
    for (const Activation activation :
         {Activation::kNone, Activation::kRectify, Activation::kSigmoid}) {
      this->device_->Launch(DenseForwardKernel{x_d->data(),
                                               w_d->data(),
                                               b_d->data(),
                                               rows_per_bias,
                                               kInputs,
                                               kOutputs,
                                               kOutputs,
                                               activation,
                                               y_d->data()},
                            kRows * kOutputs);
      std::vector<uint32_t> groups;
      for (uint32_t row = 0; row < kRows; ++row) {
        groups.push_back(rows_per_bias == 0 ? 0 : row / rows_per_bias);
      }
      std::vector<float> expected(kRows * kOutputs);
      DenseForward(x.data(),
                   w.data(),
                   b.data(),
                   groups.data(),
                   kRows,
                   kInputs,
                   kOutputs,
                   activation == Activation::kRectify,
                   expected.data());
      if (activation == Activation::kSigmoid) {
        Sigmoid(expected.size(), expected.data());
      }
      this->ExpectNear(y_d->Download(kRows * kOutputs), expected, 1e-5);
    }
  }
}

// Only the first columns of w count.
TYPED_TEST(DenseLayerKernelsTest, DenseForwardOfSomeColumns) {
  const auto w_d = this->Upload({1, 2, 3, 9, 4, 5, 6, 9});
  const auto x_d = this->Upload({10, 100, -1, 0});
  const auto b_d = this->Upload({0.5, 0.25, 0});
  const auto y_d = this->Upload(std::vector<float>(6));
  this->device_->Launch(DenseForwardKernel{x_d->data(),
                                           w_d->data(),
                                           b_d->data(),
                                           0,
                                           2,
                                           3,
                                           4,
                                           Activation::kNone,
                                           y_d->data()},
                        6);
  this->ExpectNear(
      y_d->Download(6), {410.5, 520.25, 630, -0.5, -1.75, -3}, 1e-4);
}

TYPED_TEST(DenseLayerKernelsTest, TransposeOfSomeColumns) {
  const auto matrix = this->Upload({1, 2, 9, 3, 4, 9, 5, 6, 9});
  const auto transposed = this->Upload(std::vector<float>(6));
  this->device_->Launch(
      TransposeKernel{matrix->data(), 3, 3, transposed->data()}, 6);
  EXPECT_EQ(transposed->Download(6), std::vector<float>({1, 3, 5, 2, 4, 6}));
}

TYPED_TEST(DenseLayerKernelsTest, DenseBackward) {
  constexpr uint32_t kInputs = 32;
  constexpr uint32_t kOutputs = 16;
  auto x = RandomValues(kRows * kInputs, -1, 1, 1);
  for (float& value : x) {
    value = std::max(value, 0.0f);
  }
  const auto w = RandomValues(kInputs * kOutputs, -1, 1, 2);
  const auto dy = RandomValues(kRows * kOutputs, -1, 1, 3);
  const auto x_d = this->Upload(x);
  const auto w_d = this->Upload(w);
  const auto dy_d = this->Upload(dy);
  const auto dx_d = this->Upload(std::vector<float>(x.size(), 9.0f));
  std::vector<float> w_transposed(w.size());
  for (size_t i = 0; i < kInputs; ++i) {
    for (size_t j = 0; j < kOutputs; ++j) {
      w_transposed[j * kInputs + i] = w[i * kOutputs + j];
    }
  }
  const auto w_transposed_d = this->Upload(std::vector<float>(w.size()));
  this->device_->Launch(
      TransposeKernel{w_d->data(), kInputs, kOutputs, w_transposed_d->data()},
      w.size());
  ASSERT_EQ(w_transposed_d->Download(w.size()), w_transposed);
  for (const bool is_masked : {false, true}) {
    this->device_->Launch(
        DenseBackwardInputKernel{dy_d->data(),
                                 w_transposed_d->data(),
                                 is_masked ? x_d->data() : nullptr,
                                 kInputs,
                                 kOutputs,
                                 dx_d->data()},
        x.size());
    std::vector<float> expected(x.size());
    DenseBackwardInput(dy.data(),
                       kOutputs,
                       w_transposed.data(),
                       is_masked ? x.data() : nullptr,
                       kRows,
                       kInputs,
                       kOutputs,
                       expected.data());
    this->ExpectNear(dx_d->Download(x.size()), expected, 1e-5);
  }

  const size_t num_parameters = (kInputs + 1) * kOutputs;
  const size_t num_chunks = DenseBackwardWeightsKernel::NumChunks(kRows);
  EXPECT_EQ(num_chunks, 3u);
  const auto parts_d =
      this->Upload(std::vector<float>(num_chunks * num_parameters, 9.0f));
  const auto sums_d = this->Upload(std::vector<float>(num_parameters, 0.5f));
  const DenseBackwardWeightsKernel kernel{x_d->data(),
                                          dy_d->data(),
                                          kRows,
                                          kInputs,
                                          kOutputs,
                                          kOutputs,
                                          /*has_biases=*/true,
                                          num_parameters,
                                          parts_d->data()};
  this->device_->Launch(kernel, kernel.NumCalls());
  this->device_->Launch(
      SumChunksKernel{
          parts_d->data(), num_chunks, num_parameters, sums_d->data()},
      num_parameters);
  std::vector<float> expected(num_parameters, 0.5f);
  DenseBackwardWeights(
      x.data(), kInputs, dy.data(), kRows, kInputs, kOutputs, expected.data());
  DenseSumRows(dy.data(),
               nullptr,
               kRows,
               kOutputs,
               expected.data() + kInputs * kOutputs);
  this->ExpectNear(sums_d->Download(num_parameters), expected, 1e-3);
}

TYPED_TEST(DenseLayerKernelsTest, SumsOfGroupsAndColumns) {
  const auto x = RandomValues(12 * 16, -1, 1, 1);
  const auto x_d = this->Upload(x);
  const auto sums_d = this->Upload(std::vector<float>(4 * 16));
  this->device_->Launch(SumGroupsKernel{x_d->data(), 3, 16, sums_d->data()},
                        4 * 16);
  std::vector<uint32_t> groups;
  for (uint32_t row = 0; row < 12; ++row) {
    groups.push_back(row / 3);
  }
  std::vector<float> expected(4 * 16);
  DenseSumRows(x.data(), groups.data(), 12, 16, expected.data());
  this->ExpectNear(sums_d->Download(4 * 16), expected, 1e-5);

  const auto to_d = this->Upload({0, 0, 0});
  this->device_->Launch(CopyColumnKernel{x_d->data() + 1, 16, to_d->data()}, 3);
  EXPECT_EQ(to_d->Download(3), (std::vector<float>{x[1], x[17], x[33]}));
  this->device_->Launch(AddToColumnKernel{to_d->data(), 16, x_d->data()}, 3);
  EXPECT_EQ(x_d->Download(17)[16], x[16] + x[17]);
}

}  // namespace
}  // namespace structnerf
