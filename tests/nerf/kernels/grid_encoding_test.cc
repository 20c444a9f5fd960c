#include "nerf/kernels/grid_encoding.h"

#include "nerf/kernels/half_precision.h"
#include "tests/nerf/random_values.h"
#include "tests/nerf/simd_targets.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace structnerf {
namespace {

constexpr size_t kStride = 48;

const Eigen::Vector3f kExtent(1.0f, 0.7f, 0.45f);

class GridEncodingTest : public SimdTargetTest {};

// A dense and two hashed levels, the last with more vertices along an axis than
// a bucket has entries.
std::vector<GridLevel> Levels() {
  FieldOptions options;
  options.num_levels = 3;
  options.log2_table_size = 12;
  options.min_resolution = 9;
  options.max_resolution = 3000;
  const FieldLayout layout(options, kExtent);
  EXPECT_FALSE(layout.levels[0].hashed);
  EXPECT_TRUE(layout.levels[1].hashed);
  EXPECT_TRUE(layout.levels[2].hashed);
  return layout.levels;
}

struct Points {
  std::vector<float> x;
  std::vector<float> y;
  std::vector<float> z;
};

// Points inside of the box, a few outside, on its faces and on cell borders.
Points MakePoints(const GridLevel& level, const size_t count) {
  Points points;
  std::vector<float>* const axes[3] = {&points.x, &points.y, &points.z};
  for (int axis = 0; axis < 3; ++axis) {
    *axes[axis] =
        RandomValues(count + 16, -0.1f, kExtent[axis] + 0.1f, count + axis);
    const float special[] = {
        0.0f, kExtent[axis], -3.0f, 1e9f, 2.0f / level.cells_per_unit, -1e-30f};
    for (size_t i = 0; i < std::size(special); ++i) {
      const size_t index = 3 * i + axis;
      if (index < count) {
        (*axes[axis])[index] = special[i];
      }
    }
  }
  return points;
}

struct Corner {
  uint32_t entry;
  float weight;
};

// The eight corners around a point, in plain code.
std::array<Corner, 8> ScalarCorners(const GridLevel& level,
                                    const float x,
                                    const float y,
                                    const float z) {
  const float position[3] = {x, y, z};
  uint32_t cell[3];
  float upper_weight[3];
  for (int axis = 0; axis < 3; ++axis) {
    const float last_cell = static_cast<float>(level.vertices[axis] - 2);
    const float scaled = std::min(
        std::max(position[axis] * level.cells_per_unit, 0.0f), last_cell);
    cell[axis] = static_cast<uint32_t>(scaled);
    upper_weight[axis] = scaled - static_cast<float>(cell[axis]);
  }
  std::array<Corner, 8> corners;
  for (int corner = 0; corner < 8; ++corner) {
    uint32_t vertex[3];
    float weight = 1;
    for (int axis = 0; axis < 3; ++axis) {
      const int side = (corner >> axis) & 1;
      vertex[axis] = cell[axis] + side;
      weight *= side ? upper_weight[axis] : 1 - upper_weight[axis];
    }
    if (level.hashed) {
      corners[corner].entry =
          (vertex[0] ^ (vertex[1] * 2654435761u) ^ (vertex[2] * 805459861u)) &
          (level.num_entries - 1);
    } else {
      corners[corner].entry =
          vertex[0] +
          level.vertices[0] * (vertex[1] + level.vertices[1] * vertex[2]);
    }
    corners[corner].weight = weight;
  }
  return corners;
}

TEST_P(GridEncodingTest, Corners) {
  for (const GridLevel& level : Levels()) {
    for (size_t count = 0; count <= kStride; ++count) {
      const Points points = MakePoints(level, count);
      std::vector<uint32_t> entries(8 * kStride);
      std::vector<float> weights(8 * kStride);
      GridCorners(level,
                  points.x.data(),
                  points.y.data(),
                  points.z.data(),
                  count,
                  kStride,
                  entries.data(),
                  weights.data());
      for (size_t s = 0; s < count; ++s) {
        const auto expected =
            ScalarCorners(level, points.x[s], points.y[s], points.z[s]);
        float sum = 0;
        for (int corner = 0; corner < 8; ++corner) {
          const size_t index = corner * kStride + s;
          ASSERT_LT(entries[index], level.num_entries);
          ASSERT_EQ(entries[index], expected[corner].entry);
          ASSERT_NEAR(weights[index], expected[corner].weight, 1e-6);
          ASSERT_GE(weights[index], 0);
          sum += weights[index];
        }
        ASSERT_NEAR(sum, 1, 1e-6);
      }
    }
  }
}

TEST_P(GridEncodingTest, CornerPairsAreTheSameCorners) {
  for (const GridLevel& level : Levels()) {
    const size_t count = kStride - 3;
    const Points points = MakePoints(level, count);
    std::vector<uint32_t> buckets(4 * kStride);
    std::vector<CornerPair> pairs(4 * kStride);
    GridCornerPairs(level,
                    points.x.data(),
                    points.y.data(),
                    points.z.data(),
                    count,
                    kStride,
                    buckets.data(),
                    pairs.data());
    for (size_t s = 0; s < count; ++s) {
      const auto expected =
          ScalarCorners(level, points.x[s], points.y[s], points.z[s]);
      for (int pair = 0; pair < 4; ++pair) {
        const CornerPair& actual = pairs[pair * kStride + s];
        const uint32_t bucket = buckets[pair * kStride + s];
        const uint32_t first =
            (bucket & 0xffff) * kBucketEntries +
            ((actual.index >> kTileSampleBits) & (kBucketEntries - 1));
        const uint32_t second =
            (bucket >> 16) * kBucketEntries +
            (actual.index >> (kTileSampleBits + kBucketBits));
        ASSERT_EQ(actual.index & ((1u << kTileSampleBits) - 1), s);
        ASSERT_EQ(first, expected[2 * pair].entry);
        ASSERT_EQ(second, expected[2 * pair + 1].entry);
        ASSERT_NEAR(actual.weights[0], expected[2 * pair].weight, 1e-6);
        ASSERT_NEAR(actual.weights[1], expected[2 * pair + 1].weight, 1e-6);
      }
    }
  }
}

TEST_P(GridEncodingTest, Interpolate) {
  constexpr size_t kWidth = 32;
  constexpr size_t kOffset = 8;
  constexpr float kUntouched = 7.0f;
  for (const GridLevel& level : Levels()) {
    std::vector<float> values =
        RandomValues(level.num_entries * kGridFeatures, -1, 1, 5);
    std::vector<hwy::float16_t> table(values.size());
    HalfFromFloat(values.data(), values.size(), table.data());
    FloatFromHalf(table.data(), table.size(), values.data());
    for (const size_t count : {0, 1, 2, 15, 16, 17, 45}) {
      const Points points = MakePoints(level, count);
      std::vector<uint32_t> entries(8 * kStride);
      std::vector<float> weights(8 * kStride);
      GridCorners(level,
                  points.x.data(),
                  points.y.data(),
                  points.z.data(),
                  count,
                  kStride,
                  entries.data(),
                  weights.data());
      std::vector<float> encoding(kStride * kWidth, kUntouched);
      const float scale = 0.75f;
      GridInterpolate(table.data(),
                      entries.data(),
                      weights.data(),
                      count,
                      kStride,
                      scale,
                      kWidth,
                      encoding.data() + kOffset);
      for (size_t s = 0; s < kStride; ++s) {
        for (size_t f = 0; f < kWidth; ++f) {
          const float actual = encoding[s * kWidth + f];
          if (s >= count || f < kOffset || f >= kOffset + kGridFeatures) {
            ASSERT_EQ(actual, kUntouched);
            continue;
          }
          double expected = 0;
          for (const Corner& corner :
               ScalarCorners(level, points.x[s], points.y[s], points.z[s])) {
            expected += scale * corner.weight *
                        values[corner.entry * kGridFeatures + f - kOffset];
          }
          ASSERT_NEAR(actual, expected, 2e-6);
        }
      }
    }
  }
}

// Features must not jump where a sample moves into the next cell.
TEST_P(GridEncodingTest, IsContinuousAcrossCells) {
  const GridLevel level = Levels()[1];
  const float border = 5 / level.cells_per_unit;
  std::vector<float> x(kStride);
  for (size_t s = 0; s < kStride; ++s) {
    x[s] = border * (1 + 1e-6f * (static_cast<float>(s) - kStride / 2));
  }
  const std::vector<float> yz(kStride, 0.2f);
  std::vector<uint32_t> entries(8 * kStride);
  std::vector<float> weights(8 * kStride);
  GridCorners(level,
              x.data(),
              yz.data(),
              yz.data(),
              kStride,
              kStride,
              entries.data(),
              weights.data());
  EXPECT_NE(entries[0], entries[kStride - 1]);
  const auto values = RandomValues(level.num_entries * kGridFeatures, -1, 1, 5);
  std::vector<hwy::float16_t> table(values.size());
  HalfFromFloat(values.data(), values.size(), table.data());
  std::vector<float> encoding(kStride * kGridFeatures);
  GridInterpolate(table.data(),
                  entries.data(),
                  weights.data(),
                  kStride,
                  kStride,
                  1.0f,
                  kGridFeatures,
                  encoding.data());
  for (size_t i = kGridFeatures; i < encoding.size(); ++i) {
    EXPECT_NEAR(encoding[i], encoding[i - kGridFeatures], 1e-4);
  }
}

STRUCTNERF_FOR_EACH_SIMD_TARGET(GridEncodingTest);

}  // namespace
}  // namespace structnerf
