// Kernels against their twins on the CPU.

#include "nerf/kernels/grid_encoding.h"

#include "nerf/cuda/grid_encoding-inl.h"
#include "nerf/field/field_layout.h"
#include "nerf/kernels/grid_gradient.h"
#include "nerf/kernels/half_precision.h"
#include "tests/nerf/cuda/test_devices.h"
#include "tests/nerf/random_values.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <hwy/base.h>

namespace structnerf {
namespace {

template <class Device>
class GridEncodingKernelsTest : public DeviceTest<Device> {};

TYPED_TEST_SUITE(GridEncodingKernelsTest, TestDevices);

// Points of which some lie outside, at corners, or nowhere.
std::vector<float> GridPoints(const uint64_t seed) {
  auto points = RandomValues(320, -0.1f, 1.1f, seed);
  points[0] = 0;
  points[1] = 1;
  points[2] = std::numeric_limits<float>::quiet_NaN();
  points[3] = std::numeric_limits<float>::infinity();
  points[4] = -points[3];
  return points;
}

TYPED_TEST(GridEncodingKernelsTest, Grid) {
  FieldOptions options;
  options.num_levels = 3;
  options.log2_table_size = 10;
  options.min_resolution = 4;  // dense, then hashed
  options.max_resolution = 64;
  const FieldLayout layout(options, Eigen::Vector3f(1.0f, 0.7f, 0.9f));
  ASSERT_FALSE(layout.levels[0].hashed);
  ASSERT_TRUE(layout.levels[2].hashed);
  const size_t width = layout.encoding_width;
  const std::vector<float> points[3] = {
      GridPoints(1), GridPoints(2), GridPoints(3)};
  const size_t num_points = points[0].size();
  auto table = RandomValues(layout.num_grid_entries * kGridFeatures, -1, 1, 4);
  std::vector<hwy::float16_t> half_table(table.size());
  HalfFromFloat(table.data(), table.size(), half_table.data());
  FloatFromHalf(half_table.data(), table.size(), table.data());
  const auto d_encoding = RandomValues(num_points * width, -1, 1, 5);

  DeviceGrid grid = {};
  grid.num_levels = 3;
  std::vector<float> encoding(num_points * width);
  std::vector<float> gradient(table.size());
  std::vector<uint32_t> entries(8 * num_points);
  std::vector<float> weights(8 * num_points);
  for (int l = 0; l < 3; ++l) {
    const GridLevel& level = layout.levels[l];
    const float scale = 1.0f / (1 + l);
    grid.levels[l] = {level.cells_per_unit,
                      {level.vertices[0], level.vertices[1], level.vertices[2]},
                      level.hashed,
                      level.num_entries,
                      level.first_entry,
                      scale};
    GridCorners(level,
                points[0].data(),
                points[1].data(),
                points[2].data(),
                num_points,
                num_points,
                entries.data(),
                weights.data());
    GridInterpolate(half_table.data() + level.first_entry * kGridFeatures,
                    entries.data(),
                    weights.data(),
                    num_points,
                    num_points,
                    scale,
                    width,
                    encoding.data() + l * kGridFeatures);
    for (size_t i = 0; i < 8 * num_points; ++i) {
      for (int f = 0; f < kGridFeatures; ++f) {
        gradient[(level.first_entry + entries[i]) * kGridFeatures + f] +=
            scale * weights[i] *
            d_encoding[i % num_points * width + l * kGridFeatures + f];
      }
    }
  }
  const auto x = this->Upload(points[0]);
  const auto y = this->Upload(points[1]);
  const auto z = this->Upload(points[2]);
  const DevicePoints device_points = {x->data(), y->data(), z->data()};
  const auto table_d = this->Upload(table);
  const auto encoding_d = this->Upload(std::vector<float>(num_points * width));
  this->device_->Launch(GridEncodeKernel{grid,
                                         device_points,
                                         table_d->data(),
                                         static_cast<uint32_t>(width),
                                         encoding_d->data()},
                        num_points * 3);
  this->ExpectNear(encoding_d->Download(encoding.size()), encoding, 1e-5);

  const auto d_encoding_d = this->Upload(d_encoding);
  const auto largest_d = this->Upload(std::vector<float>(num_points, 1.0f));
  const auto largest_of_tile_d = this->Upload({1.0f});
  const auto gradient_d = this->Upload(std::vector<float>(table.size()));
  this->device_->Launch(GridBackwardKernel{grid,
                                           device_points,
                                           d_encoding_d->data(),
                                           static_cast<uint32_t>(width),
                                           largest_d->data(),
                                           largest_of_tile_d->data(),
                                           static_cast<uint32_t>(num_points),
                                           kNegligibleGradient,
                                           gradient_d->data()},
                        num_points * 3);
  this->ExpectNear(gradient_d->Download(gradient.size()), gradient, 1e-4);
}

TYPED_TEST(GridEncodingKernelsTest, LargestGradients) {
  constexpr uint32_t kWidth = 16;
  constexpr uint32_t kTilePoints = 96;
  constexpr size_t kNumPoints = 300;  // the last tile is smaller
  auto d_encoding = RandomValues(kNumPoints * kWidth, -1, 1, 1);
  // The first tile has only small ones, among them a NaN.
  for (size_t i = 0; i < kTilePoints * kWidth; ++i) {
    d_encoding[i] *= 1e-20f;
  }
  d_encoding[5 * kWidth] = std::numeric_limits<float>::quiet_NaN();
  std::vector<float> largest(kNumPoints);
  std::vector<float> largest_of_tile(4);
  for (size_t i = 0; i < d_encoding.size(); ++i) {
    const size_t point = i / kWidth;
    if (std::abs(d_encoding[i]) > largest[point]) {
      largest[point] = std::abs(d_encoding[i]);
    }
    float& of_tile = largest_of_tile[point / kTilePoints];
    of_tile = std::max(of_tile, largest[point]);
  }
  const auto d_encoding_d = this->Upload(d_encoding);
  const auto largest_d = this->Upload(std::vector<float>(kNumPoints, 9.0f));
  const auto largest_of_tile_d = this->Upload(std::vector<float>(4));
  this->device_->Launch(LargestGradientKernel{d_encoding_d->data(),
                                              kWidth,
                                              kTilePoints,
                                              largest_d->data(),
                                              largest_of_tile_d->data()},
                        kNumPoints);
  EXPECT_EQ(largest_d->Download(kNumPoints), largest);
  EXPECT_EQ(largest_of_tile_d->Download(4), largest_of_tile);
}

// As SelectSamples leaves them out on the CPU.
TYPED_TEST(GridEncodingKernelsTest, NegligibleGradientsAddNothing) {
  DeviceGrid grid = {};
  grid.num_levels = 1;
  grid.levels[0] = {1, {2, 2, 2}, false, 8, 0, 1.0f};
  const std::vector<float> d_encoding = {4, 0,     0,     0,     0, 0, 0, 0,  //
                                         0, 2e-8f, 0,     0,     0, 0, 0, 0,
                                         0, 0,     1e-3f, 0,     0, 0, 0, 0,
                                         0, 0,     0,     3e-8f, 0, 0, 0, 0};
  const auto coordinates = this->Upload(std::vector<float>(4));
  const auto d_encoding_d = this->Upload(d_encoding);
  const auto largest_d = this->Upload({4, 2e-8f, 1e-3f, 3e-8f});
  const auto largest_of_tile_d = this->Upload({4, 1e-3f});
  const auto gradient_d = this->Upload(std::vector<float>(8 * 8));
  this->device_->Launch(
      GridBackwardKernel{
          grid,
          {coordinates->data(), coordinates->data(), coordinates->data()},
          d_encoding_d->data(),
          kDeviceFeatures,
          largest_d->data(),
          largest_of_tile_d->data(),
          /*tile_points=*/2,
          kNegligibleGradient,
          gradient_d->data()},
      4);
  EXPECT_EQ(gradient_d->Download(8),
            std::vector<float>({4, 0, 1e-3f, 3e-8f, 0, 0, 0, 0}));
}

}  // namespace
}  // namespace structnerf
