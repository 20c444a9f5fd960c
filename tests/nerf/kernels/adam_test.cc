#include "nerf/kernels/adam.h"

#include "nerf/kernels/half_precision.h"
#include "tests/nerf/random_values.h"
#include "tests/nerf/simd_targets.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

namespace structnerf {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

class AdamTest : public SimdTargetTest {};

// Adam of one parameter, by the book.
struct ScalarAdam {
  void Update(const AdamStep& step, const double gradient) {
    m = step.beta1 * m + (1 - step.beta1) * gradient;
    v = step.beta2 * v + (1 - step.beta2) * gradient * gradient;
    value -= step.learning_rate * m /
             std::sqrt(v + std::pow(static_cast<double>(step.epsilon), 2));
  }

  double value = 0;
  double m = 0;
  double v = 0;
};

TEST_P(AdamTest, PlainParameters) {
  AdamStep step;
  step.learning_rate = 0.01f;
  for (const size_t count : {0, 1, 15, 16, 17, 50}) {
    std::vector<float> value = RandomValues(count, -1, 1, 1);
    std::vector<float> m(count);
    std::vector<float> root_v(count);
    std::vector<ScalarAdam> expected(count);
    for (size_t i = 0; i < count; ++i) {
      expected[i].value = value[i];
    }
    for (int k = 0; k < 30; ++k) {
      const auto gradient = RandomValues(count, -1, 1, 100 + k);
      AdamUpdate(
          step, count, gradient.data(), m.data(), root_v.data(), value.data());
      for (size_t i = 0; i < count; ++i) {
        expected[i].Update(step, gradient[i]);
      }
    }
    for (size_t i = 0; i < count; ++i) {
      EXPECT_NEAR(value[i], expected[i].value, 3e-5);
      EXPECT_NEAR(m[i], expected[i].m, 1e-5);
      EXPECT_NEAR(root_v[i], std::sqrt(expected[i].v), 3e-5);
    }
  }
}

TEST_P(AdamTest, ZeroAndTinyGradientsAreHarmless) {
  AdamStep step;
  step.learning_rate = 0.01f;
  const std::vector<float> gradient = {0.0f, 1e-12f, -1e-25f, 1e-38f, 1e17f};
  std::vector<float> value(gradient.size(), 1.0f);
  std::vector<float> m(gradient.size());
  std::vector<float> root_v(gradient.size());
  AdamUpdate(step,
             gradient.size(),
             gradient.data(),
             m.data(),
             root_v.data(),
             value.data());
  EXPECT_EQ(value[0], 1.0f);
  // Against the epsilon of 1e-10, this is a hundredth of a step.
  EXPECT_NEAR(value[1], 1.0f - 1e-5f, 1e-6);
  EXPECT_NEAR(value[2], 1.0f, 1e-7);
  EXPECT_NEAR(value[3], 1.0f, 1e-7);
  EXPECT_NEAR(value[4], 0.99f, 1e-5);
}

// A few grid entries of which some are listed.
struct Grid {
  Grid() : state(kNumEntries), table(8 * kNumEntries) {
    gradient.resize(8 * kNumEntries);
    const auto values = RandomValues(8 * kNumEntries, -1, 1, 1);
    for (size_t entry = 0; entry < kNumEntries; ++entry) {
      std::copy_n(values.begin() + 8 * entry, 8, state[entry].value);
    }
  }

  bool Update(const AdamStep& step, const std::vector<uint16_t>& entries) {
    return AdamUpdateGrid(step,
                          entries.data(),
                          entries.size(),
                          gradient.data(),
                          state.data(),
                          table.data());
  }

  static constexpr size_t kNumEntries = 40;
  std::vector<float> gradient;
  std::vector<GridEntryState> state;
  std::vector<hwy::float16_t> table;
};

TEST_P(AdamTest, GridEntries) {
  AdamStep step;
  step.learning_rate = 0.01f;
  Grid grid;
  const Grid initial = grid;
  const std::vector<uint16_t> entries = {0, 1, 7, 39};
  std::vector<ScalarAdam> expected(8 * Grid::kNumEntries);
  for (size_t i = 0; i < expected.size(); ++i) {
    expected[i].value = initial.state[i / 8].value[i % 8];
  }
  constexpr int kNumSteps = 50;
  for (int k = 0; k < kNumSteps; ++k) {
    for (const uint16_t entry : entries) {
      const auto gradient = RandomValues(8, -1, 2, 1000 * k + entry);
      for (int f = 0; f < 8; ++f) {
        grid.gradient[8 * entry + f] = gradient[f];
        expected[8 * entry + f].Update(step, gradient[f]);
      }
    }
    ASSERT_TRUE(grid.Update(step, entries));
    for (const float gradient : grid.gradient) {
      ASSERT_EQ(gradient, 0.0f);
    }
  }
  for (size_t entry = 0; entry < Grid::kNumEntries; ++entry) {
    const GridEntryState& state = grid.state[entry];
    if (std::find(entries.begin(), entries.end(), entry) == entries.end()) {
      EXPECT_EQ(std::memcmp(&state, &initial.state[entry], sizeof(state)), 0);
      continue;
    }
    float rounded[8];
    FloatFromHalf(grid.table.data() + 8 * entry, 8, rounded);
    for (int f = 0; f < 8; ++f) {
      const ScalarAdam& reference = expected[8 * entry + f];
      // Moments are rounded in every step, which must not add up.
      const double distance =
          std::abs(reference.value - initial.state[entry].value[f]);
      EXPECT_NEAR(state.value[f],
                  reference.value,
                  0.05 * distance + 0.2 * step.learning_rate);
      EXPECT_NEAR(rounded[f], state.value[f], 1e-3);
    }
  }
}

TEST_P(AdamTest, FirstStepHasTheSizeOfTheLearningRate) {
  AdamStep step;
  step.learning_rate = 0.02f;
  for (const float gradient : {1e-6f, -1.0f, 3e4f}) {
    Grid grid;
    const float before = grid.state[3].value[2];
    grid.gradient[8 * 3 + 2] = gradient;
    ASSERT_TRUE(grid.Update(step, {3}));
    EXPECT_NEAR(
        grid.state[3].value[2], before - std::copysign(0.02f, gradient), 1e-5);
  }
}

// The rounded second moment must follow a gradient that grows or fades slowly.
TEST_P(AdamTest, MomentsFollowSlowChanges) {
  AdamStep step;
  for (const double rate : {0.002, -0.002}) {
    Grid grid;
    ScalarAdam expected;
    for (int k = 0; k < 2000; ++k) {
      const float gradient = static_cast<float>(std::exp(rate * k));
      grid.gradient[0] = gradient;
      expected.Update(step, gradient);
      ASSERT_TRUE(grid.Update(step, {0}));
    }
    const uint32_t bits =
        static_cast<uint32_t>(grid.state[0].root_second_moment[0]) << 15;
    float root_v;
    std::memcpy(&root_v, &bits, sizeof(root_v));
    EXPECT_NEAR(root_v / std::sqrt(expected.v), 1, 0.1) << rate;
  }
}

TEST_P(AdamTest, EntriesWithoutGradientAreLeftAlone) {
  AdamStep step;
  step.learning_rate = 0.1f;
  Grid grid;
  grid.gradient[8 * 5] = 1;
  ASSERT_TRUE(grid.Update(step, {5}));
  // Its momentum alone would move it on.
  const Grid before = grid;
  ASSERT_TRUE(grid.Update(step, {5}));
  EXPECT_EQ(
      std::memcmp(&grid.state[5], &before.state[5], sizeof(GridEntryState)), 0);
}

TEST_P(AdamTest, RefusesGradientsThatAreNotFinite) {
  AdamStep step;
  step.learning_rate = 0.1f;
  for (const float bad : {kNan, kInfinity, -kInfinity, kMaxGradient}) {
    for (int f = 0; f < 8; ++f) {
      Grid grid;
      const Grid before = grid;
      std::fill_n(grid.gradient.begin(), 8 * Grid::kNumEntries, 1.0f);
      grid.gradient[8 * 2 + f] = bad;
      EXPECT_FALSE(grid.Update(step, {1, 2, 3}));
      EXPECT_EQ(
          std::memcmp(&grid.state[2], &before.state[2], sizeof(GridEntryState)),
          0);
      EXPECT_NE(grid.state[1].value[0], before.state[1].value[0]);
      EXPECT_NE(grid.state[3].value[0], before.state[3].value[0]);
      // The next step must not see it again.
      EXPECT_EQ(grid.gradient[8 * 2 + f], 0.0f);
    }
  }
}

STRUCTNERF_FOR_EACH_SIMD_TARGET(AdamTest);

}  // namespace
}  // namespace structnerf
