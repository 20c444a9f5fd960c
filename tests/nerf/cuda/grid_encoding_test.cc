// Kernels against their twins on the CPU.

#include "nerf/kernels/grid_encoding.h"

#include "nerf/cuda/grid_encoding-inl.h"
#include "nerf/field/field_layout.h"
#include "nerf/kernels/half_precision.h"
#include "tests/nerf/cuda/test_devices.h"
#include "tests/nerf/random_values.h"

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
  const auto gradient_d = this->Upload(std::vector<float>(table.size()));
  this->device_->Launch(GridBackwardKernel{grid,
                                           device_points,
                                           d_encoding_d->data(),
                                           static_cast<uint32_t>(width),
                                           gradient_d->data()},
                        num_points * 3);
  this->ExpectNear(gradient_d->Download(gradient.size()), gradient, 1e-4);
}

}  // namespace
}  // namespace structnerf
