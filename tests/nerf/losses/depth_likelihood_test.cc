#include "nerf/losses/depth_likelihood.h"

#include "nerf/util/random.h"
#include "tests/support/numeric_gradient.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

namespace structnerf {
namespace {

constexpr float kUnit = 0.4f;

struct Result {
  float loss = 0;
  double d_depth = 0;     // in all
  double d_variance = 0;  // in all
};

Result Evaluate(const PriorDepth& prior,
                const float depth,
                const float variance,
                const float weight) {
  RayOutputs outputs = {};
  outputs.depth[3] = depth;
  outputs.depth_variance[3] = variance;
  RayGradients gradients;
  Result result;
  result.loss =
      EvaluateDepthLikelihood(prior, weight, kUnit, outputs, 3, &gradients);
  // pull * sum w ((z - pull_z) / pull_z)^2 is pull / pull_z^2 (V + (D -
  // pull_z)^2).
  const double pull_z = gradients.pull_z[3];
  const double pull =
      gradients.pull[3] != 0 ? gradients.pull[3] / (pull_z * pull_z) : 0.0;
  result.d_variance = pull;
  result.d_depth = gradients.d_depth[3] + 2 * pull * (depth - pull_z);
  return result;
}

// The documented formula in double precision.
double Reference(const PriorDepth& prior,
                 const double depth,
                 const double variance) {
  const double unit = kUnit;
  const double v = variance / (unit * unit) + 1e-6;
  const double offset = (depth - prior.depth) / unit;
  return std::log(v) + offset * offset / v;
}

TEST(EvaluateDepthLikelihood, GradientIsThatOfTheFormula) {
  Random random(1);
  for (int round = 0; round < 500; ++round) {
    const PriorDepth prior = {0.3f + random.NextFloat(), 0.01f};
    const float depth = prior.depth * (1.05f + 0.3f * random.NextFloat());
    const float deviation = 0.02f + 0.2f * random.NextFloat();
    const float variance = deviation * deviation;
    const Result result = Evaluate(prior, depth, variance, 3);
    const auto reference = [&](const std::vector<double>& at) {
      return 3 * Reference(prior, at[0], at[1]);
    };
    const std::vector<double> exact = {depth, variance};
    EXPECT_NEAR(
        result.loss, reference(exact), 1e-4 * (1 + std::abs(result.loss)));
    const std::vector<double> expected =
        NumericGradient(reference, exact, 1e-7);
    EXPECT_NEAR(
        result.d_depth, expected[0], 1e-3 * (1 + std::abs(expected[0])));
    EXPECT_NEAR(
        result.d_variance, expected[1], 1e-3 * (1 + std::abs(expected[1])));
  }
}

TEST(EvaluateDepthLikelihood, WithinTheDeviationNothingIsKnown) {
  const PriorDepth prior = {1, 0.1f};
  const Result inside = Evaluate(prior, 1.05f, 0.05f * 0.05f, 1);
  EXPECT_EQ(inside.loss, 0);
  EXPECT_EQ(inside.d_depth, 0);
  EXPECT_EQ(inside.d_variance, 0);
  // Too far off, or too spread out.
  EXPECT_NE(Evaluate(prior, 1.11f, 0.05f * 0.05f, 1).d_depth, 0);
  EXPECT_GT(Evaluate(prior, 1.05f, 0.11f * 0.11f, 1).d_variance, 0);
}

TEST(EvaluateDepthLikelihood, SharpRaysInTheWrongPlaceAreSpread) {
  const PriorDepth prior = {1, 0.05f};
  EXPECT_LT(Evaluate(prior, 1.3f, 0.01f * 0.01f, 1).d_variance, 0);
  EXPECT_TRUE(std::isfinite(Evaluate(prior, 1.3f, 0, 1).d_variance));
}

}  // namespace
}  // namespace structnerf
