#include "nerf/kernels/dense_layer.h"

#include "tests/nerf/random_values.h"
#include "tests/nerf/simd_targets.h"

#include <cmath>
#include <limits>
#include <tuple>
#include <vector>

namespace structnerf {
namespace {

constexpr int kWidths[] = {16, 32, 48, 64};

// Row counts around the sizes of register blocks.
constexpr int kRowCounts[] = {0, 1, 3, 4, 5, 7, 8, 11, 12, 13, 17, 29, 64, 131};

// Sums of up to 131 products of numbers below one.
constexpr float kTolerance = 2e-5f;

class DenseLayerTest : public SimdTargetTest {};

void ExpectNear(const std::vector<float>& actual,
                const std::vector<double>& expected) {
  ASSERT_EQ(actual.size(), expected.size());
  for (size_t i = 0; i < actual.size(); ++i) {
    ASSERT_NEAR(actual[i], expected[i], kTolerance) << "at " << i;
  }
}

TEST_P(DenseLayerTest, Forward) {
  for (const int num_inputs : {1, 3, 16, 32, 48, 64}) {
    for (const int num_outputs : kWidths) {
      const auto w = RandomValues(num_inputs * num_outputs, -1, 1, num_inputs);
      const auto b = RandomValues(num_outputs, -1, 1, num_outputs);
      for (const int rows : kRowCounts) {
        const auto x = RandomValues(rows * num_inputs, -1, 1, rows);
        for (const bool rectify : {false, true}) {
          std::vector<double> expected(rows * num_outputs);
          for (int r = 0; r < rows; ++r) {
            for (int j = 0; j < num_outputs; ++j) {
              double sum = b[j];
              for (int k = 0; k < num_inputs; ++k) {
                sum += static_cast<double>(x[r * num_inputs + k]) *
                       w[k * num_outputs + j];
              }
              expected[r * num_outputs + j] =
                  rectify ? std::max(sum, 0.0) : sum;
            }
          }
          std::vector<float> y(rows * num_outputs);
          DenseForward(x.data(),
                       w.data(),
                       b.data(),
                       nullptr,
                       rows,
                       num_inputs,
                       num_outputs,
                       rectify,
                       y.data());
          ExpectNear(y, expected);
        }
      }
    }
  }
}

TEST_P(DenseLayerTest, ForwardTakesBiasesByGroup) {
  constexpr int kRows = 37;
  constexpr int kInputs = 16;
  constexpr int kGroups = 5;
  for (const int num_outputs : kWidths) {
    const auto x = RandomValues(kRows * kInputs, -1, 1, 1);
    const auto w = RandomValues(kInputs * num_outputs, -1, 1, 2);
    const auto b = RandomValues(kGroups * num_outputs, -1, 1, 3);
    std::vector<uint32_t> groups(kRows);
    std::vector<double> expected(kRows * num_outputs);
    for (int r = 0; r < kRows; ++r) {
      groups[r] = r * kGroups / kRows;
      for (int j = 0; j < num_outputs; ++j) {
        double sum = b[groups[r] * num_outputs + j];
        for (int k = 0; k < kInputs; ++k) {
          sum +=
              static_cast<double>(x[r * kInputs + k]) * w[k * num_outputs + j];
        }
        expected[r * num_outputs + j] = sum;
      }
    }
    std::vector<float> y(kRows * num_outputs);
    DenseForward(x.data(),
                 w.data(),
                 b.data(),
                 groups.data(),
                 kRows,
                 kInputs,
                 num_outputs,
                 /*rectify=*/false,
                 y.data());
    ExpectNear(y, expected);
  }
}

TEST_P(DenseLayerTest, BackwardInput) {
  for (const int num_inputs : kWidths) {
    for (const int num_outputs : {3, 16, 32, 48, 64}) {
      const int dy_stride = (num_outputs + 15) / 16 * 16;
      const auto w_transposed =
          RandomValues(num_inputs * num_outputs, -1, 1, num_inputs);
      for (const int rows : kRowCounts) {
        const auto dy = RandomValues(rows * dy_stride, -1, 1, rows);
        const auto activation = RandomValues(rows * num_inputs, -1, 1, 7);
        for (const bool masked : {false, true}) {
          std::vector<double> expected(rows * num_inputs);
          for (int r = 0; r < rows; ++r) {
            for (int k = 0; k < num_inputs; ++k) {
              double sum = 0;
              for (int j = 0; j < num_outputs; ++j) {
                sum += static_cast<double>(dy[r * dy_stride + j]) *
                       w_transposed[j * num_inputs + k];
              }
              const bool off = masked && activation[r * num_inputs + k] <= 0;
              expected[r * num_inputs + k] = off ? 0.0 : sum;
            }
          }
          std::vector<float> dx(rows * num_inputs);
          DenseBackwardInput(dy.data(),
                             dy_stride,
                             w_transposed.data(),
                             masked ? activation.data() : nullptr,
                             rows,
                             num_inputs,
                             num_outputs,
                             dx.data());
          ExpectNear(dx, expected);
        }
      }
    }
  }
}

TEST_P(DenseLayerTest, MaskIsClosedAtZero) {
  const std::vector<float> dy(16, 1.0f);
  const std::vector<float> w_transposed(16 * 16, 1.0f);
  std::vector<float> activation(16, 1.0f);
  activation[3] = 0.0f;
  activation[5] = -0.0f;
  std::vector<float> dx(16);
  DenseBackwardInput(dy.data(),
                     16,
                     w_transposed.data(),
                     activation.data(),
                     1,
                     16,
                     16,
                     dx.data());
  for (int k = 0; k < 16; ++k) {
    EXPECT_EQ(dx[k], k == 3 || k == 5 ? 0.0f : 16.0f);
  }
}

TEST_P(DenseLayerTest, BackwardWeightsAddsUp) {
  for (const int num_inputs : {3, 16, 32, 48, 64}) {
    const int x_stride = (num_inputs + 15) / 16 * 16;
    for (const int num_outputs : kWidths) {
      for (const int rows : kRowCounts) {
        const auto x = RandomValues(rows * x_stride, -1, 1, 1);
        const auto dy = RandomValues(rows * num_outputs, -1, 1, 2);
        auto dw = RandomValues(num_inputs * num_outputs, -1, 1, 3);
        std::vector<double> expected(dw.begin(), dw.end());
        for (int r = 0; r < rows; ++r) {
          for (int k = 0; k < num_inputs; ++k) {
            for (int j = 0; j < num_outputs; ++j) {
              expected[k * num_outputs + j] +=
                  static_cast<double>(x[r * x_stride + k]) *
                  dy[r * num_outputs + j];
            }
          }
        }
        DenseBackwardWeights(x.data(),
                             x_stride,
                             dy.data(),
                             rows,
                             num_inputs,
                             num_outputs,
                             dw.data());
        ExpectNear(dw, expected);
      }
    }
  }
}

TEST_P(DenseLayerTest, SumRowsAddsUpByGroup) {
  constexpr int kRows = 23;
  for (const int width : kWidths) {
    const auto x = RandomValues(kRows * width, -1, 1, 1);
    for (const int num_groups : {1, 4}) {
      std::vector<uint32_t> groups(kRows);
      auto sums = RandomValues(num_groups * width, -1, 1, 2);
      std::vector<double> expected(sums.begin(), sums.end());
      for (int r = 0; r < kRows; ++r) {
        // Groups in runs, one of which comes back.
        groups[r] = r / 5 % num_groups;
        for (int j = 0; j < width; ++j) {
          expected[groups[r] * width + j] += x[r * width + j];
        }
      }
      DenseSumRows(x.data(),
                   num_groups == 1 ? nullptr : groups.data(),
                   kRows,
                   width,
                   sums.data());
      ExpectNear(sums, expected);
    }
  }
}

TEST_P(DenseLayerTest, SigmoidSaturatesQuietly) {
  std::vector<float> x = RandomValues(16, -5, 5, 1);
  x[0] = 0;
  x[1] = 1e4f;
  x[2] = -1e4f;
  x[3] = std::numeric_limits<float>::infinity();
  x[4] = -std::numeric_limits<float>::infinity();
  std::vector<float> y = x;
  Sigmoid(y.size(), y.data());
  for (size_t i = 0; i < x.size(); ++i) {
    EXPECT_NEAR(y[i], 1 / (1 + std::exp(-static_cast<double>(x[i]))), 1e-6)
        << x[i];
  }
}

STRUCTNERF_FOR_EACH_SIMD_TARGET(DenseLayerTest);

}  // namespace
}  // namespace structnerf
