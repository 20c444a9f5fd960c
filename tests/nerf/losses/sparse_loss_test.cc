#include "nerf/losses/sparse_loss.h"

#include "nerf/util/random.h"
#include "tests/support/numeric_gradient.h"

#include <cmath>
#include <numeric>
#include <stdexcept>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace structnerf {
namespace {

using testing::HasSubstr;

TEST(SparseFormFromName, KnowsItsNames) {
  EXPECT_EQ(SparseFormFromName("line_of_sight"), SparseForm::kLineOfSight);
  EXPECT_EQ(SparseFormFromName("squared"), SparseForm::kSquared);
  EXPECT_EQ(SparseFormFromName("kl"), SparseForm::kRayTermination);
  try {
    SparseFormFromName("KL");
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(), HasSubstr("line_of_sight, squared or kl"));
  }
}

TEST(EvaluateSquaredDepth, ByHand) {
  SparseTarget target;
  target.depth = 0.5f;
  target.weight = 3;
  RayOutputs outputs = {};
  outputs.depth[7] = 0.7f;
  outputs.depth_variance[7] = 9;  // plays no role
  RayGradients gradients;
  gradients.d_depth[7] = 1;
  // (0.2 / 0.4)^2 and 2 * 0.2 / 0.4^2, both three times.
  EXPECT_NEAR(
      EvaluateSquaredDepth(target, 0.4f, outputs, 7, &gradients), 0.75, 1e-6);
  EXPECT_NEAR(gradients.d_depth[7], 1 + 7.5, 1e-5);
  EXPECT_EQ(gradients.pull[7], 0);
}

TEST(EvaluateLineOfSight, ByHand) {
  SparseTarget target;
  target.depth = 0.5f;
  target.weight = 3;
  RayOutputs outputs = {};
  outputs.depth[7] = 0.7f;
  outputs.depth_variance[7] = 0.01f;
  RayGradients gradients;
  EXPECT_NEAR(EvaluateLineOfSight(target, outputs, 7, &gradients),
              3 * (0.04 + 0.01) / 0.25,
              1e-5);
  EXPECT_EQ(gradients.pull[7], 3);
  EXPECT_EQ(gradients.pull_z[7], 0.5f);
  EXPECT_EQ(gradients.d_depth[7], 0);
}

// Two rays of random intervals and weights.
struct TwoRays {
  static constexpr int kNumSamples = 12;

  explicit TwoRays(const uint64_t seed) {
    Random random(seed);
    for (int ray = 0; ray < 2; ++ray) {
      float edge = 0.1f;
      edges.push_back(edge);
      float sum = 0;
      for (int i = 0; i < kNumSamples; ++i) {
        edge += 0.02f + 0.1f * random.NextFloat();
        edges.push_back(edge);
        weight.push_back(random.NextFloat());
        sum += weight.back();
      }
      for (int i = 0; i < kNumSamples; ++i) {
        weight[ray * kNumSamples + i] /= sum;
      }
    }
    samples = {kNumSamples, edges.data(), weight.data()};
  }

  std::vector<float> edges;
  std::vector<float> weight;
  RaySamples samples;
};

// The documented formula in double precision.
double ReferenceTermination(const SparseTarget& target,
                            const float* edges,
                            const std::vector<double>& weight) {
  const auto below = [&](const double z) {
    return 0.5 *
           std::erfc((target.depth - z) / (target.deviation * std::sqrt(2.0)));
  };
  double loss = 0;
  const size_t n = weight.size();
  for (size_t i = 0; i < n; ++i) {
    const double begin = i == 0 ? 0.0 : below(edges[i]);
    const double end = i + 1 == n ? 1.0 : below(edges[i + 1]);
    loss -= target.weight * (end - begin) * std::log(weight[i] + 1e-5);
  }
  return loss;
}

TEST(EvaluateRayTermination, GradientIsThatOfTheFormula) {
  for (uint64_t seed = 0; seed < 50; ++seed) {
    const TwoRays rays(seed);
    Random random(100 + seed);
    SparseTarget target;
    target.depth = 0.05f + 1.2f * random.NextFloat();  // also off the ray
    target.deviation = 0.01f + 0.3f * random.NextFloat();
    target.weight = 2;
    const int ray = static_cast<int>(seed % 2);
    const int first = ray * TwoRays::kNumSamples;
    std::vector<float> d_weight(rays.weight.size(), 0.5f);
    const float loss =
        EvaluateRayTermination(target, rays.samples, ray, d_weight.data());

    const std::vector<double> exact(
        rays.weight.begin() + first,
        rays.weight.begin() + first + TwoRays::kNumSamples);
    const float* const edges =
        rays.edges.data() + ray * (TwoRays::kNumSamples + 1);
    const auto reference = [&](const std::vector<double>& at) {
      return ReferenceTermination(target, edges, at);
    };
    EXPECT_NEAR(loss, reference(exact), 1e-4 * (1 + loss));
    const std::vector<double> expected =
        NumericGradient(reference, exact, 1e-7);
    for (size_t i = 0; i < d_weight.size(); ++i) {
      const bool is_of_ray = static_cast<int>(i) / TwoRays::kNumSamples == ray;
      const double change = is_of_ray ? expected[i - first] : 0.0;
      EXPECT_NEAR(d_weight[i] - 0.5, change, 1e-3 * (1 + std::abs(change)));
    }
  }
}

// Gibbs' inequality: no other weights cost less than the distribution's own.
TEST(EvaluateRayTermination, IsLeastWhereWeightsAreTheDistribution) {
  TwoRays rays(3);
  SparseTarget target;
  target.depth = 0.5f;
  target.deviation = 0.1f;
  target.weight = 1;
  std::vector<float> shares;
  for (int i = 0; i < TwoRays::kNumSamples; ++i) {
    // The derivative by a weight is minus its share over the weight.
    std::vector<float> d_weight(rays.weight.size(), 0.0f);
    EvaluateRayTermination(target, rays.samples, 0, d_weight.data());
    shares.push_back(-d_weight[i] * (rays.weight[i] + 1e-5f));
  }
  EXPECT_NEAR(std::accumulate(shares.begin(), shares.end(), 0.0), 1, 1e-4);
  const auto loss_of = [&](const std::vector<float>& weight) {
    std::copy(weight.begin(), weight.end(), rays.weight.begin());
    std::vector<float> ignored(rays.weight.size(), 0.0f);
    return EvaluateRayTermination(target, rays.samples, 0, ignored.data());
  };
  const float least = loss_of(shares);
  for (uint64_t seed = 10; seed < 30; ++seed) {
    const TwoRays other(seed);
    EXPECT_GT(loss_of({other.weight.begin(),
                       other.weight.begin() + TwoRays::kNumSamples}),
              least);
  }
}

TEST(EvaluateRayTermination, NoWeightAtThePointIsFinite) {
  TwoRays rays(1);
  std::fill(rays.weight.begin(), rays.weight.end(), 0.0f);
  rays.weight[TwoRays::kNumSamples - 1] = 1;
  SparseTarget target;
  target.depth = 0.15f;
  target.deviation = 1e-4f;
  target.weight = 1;
  std::vector<float> d_weight(rays.weight.size(), 0.0f);
  EXPECT_NEAR(EvaluateRayTermination(target, rays.samples, 0, d_weight.data()),
              -std::log(1e-5),
              1e-3);
  for (const float derivative : d_weight) {
    EXPECT_TRUE(std::isfinite(derivative));
  }
}

}  // namespace
}  // namespace structnerf
