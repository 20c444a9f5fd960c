#include "nerf/kernels/half_precision.h"

#include "tests/nerf/random_values.h"
#include "tests/nerf/simd_targets.h"

#include <cmath>
#include <vector>

namespace structnerf {
namespace {

class HalfPrecisionTest : public SimdTargetTest {};

std::vector<float> RoundTrip(const std::vector<float>& values) {
  std::vector<hwy::float16_t> half(values.size());
  HalfFromFloat(values.data(), values.size(), half.data());
  std::vector<float> result(values.size());
  FloatFromHalf(half.data(), half.size(), result.data());
  return result;
}

// To nearest where the machine has an instruction for it, else towards zero.
TEST_P(HalfPrecisionTest, RoundsToElevenBits) {
  for (const float scale : {1e-3f, 1.0f, 1e3f}) {
    for (size_t count = 0; count < 40; ++count) {
      const auto values = RandomValues(count, -scale, scale, count);
      const auto rounded = RoundTrip(values);
      for (size_t i = 0; i < count; ++i) {
        EXPECT_LE(std::abs(rounded[i] - values[i]),
                  std::max(std::abs(values[i]) / 1024, 6e-8f));
      }
    }
  }
}

TEST_P(HalfPrecisionTest, IsExactOnHalves) {
  // Any number of eleven bits, negative ones, zero, the largest and smallest.
  const std::vector<float> values = {0.0f,
                                     1.0f,
                                     -1.0f,
                                     2047.0f,
                                     -0.333251953125f,
                                     65504.0f,
                                     -65504.0f,
                                     std::ldexp(1.0f, -14),
                                     std::ldexp(1.0f, -24),
                                     std::ldexp(1023.0f, -24)};
  const auto rounded = RoundTrip(values);
  for (size_t i = 0; i < values.size(); ++i) {
    EXPECT_EQ(rounded[i], values[i]);
  }
}

STRUCTNERF_FOR_EACH_SIMD_TARGET(HalfPrecisionTest);

}  // namespace
}  // namespace structnerf
