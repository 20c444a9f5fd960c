#include "nerf/losses/triple_product.h"

#include "nerf/util/random.h"
#include "tests/support/numeric_gradient.h"

#include <cmath>
#include <stdexcept>
#include <vector>

#include <Eigen/Geometry>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace structnerf {
namespace {

using testing::HasSubstr;

TEST(PlanarFormFromName, KnowsItsNames) {
  EXPECT_EQ(PlanarFormFromName("inverse_depth"), PlanarForm::kInverseDepth);
  EXPECT_EQ(PlanarFormFromName("triple_product"), PlanarForm::kTripleProduct);
  try {
    PlanarFormFromName("");
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(), HasSubstr("inverse_depth or triple_product"));
  }
}

// Corners of a cube's corner: A = (0, 0, 1), B = (1, 0, 1), C = (0, 1, 1),
// D = (0, 0, 3), whose triple product is 1 * 1 * 2.
TEST(EvaluateTripleProduct, ByHand) {
  const Eigen::Vector3f directions[4] = {
      {0, 0, 1}, {1, 0, 1}, {0, 1, 1}, {0, 0, 1}};
  const float depth[4] = {1, 1, 1, 3};
  float d_depth[4];
  EXPECT_NEAR(EvaluateTripleProduct(directions, depth, d_depth), 2, 1e-6);
  EXPECT_NEAR(d_depth[3], 1, 1e-6);
}

TEST(EvaluateTripleProduct, PlanesCostNothing) {
  Random random(4);
  for (int round = 0; round < 200; ++round) {
    // n . X = 1.
    const Eigen::Vector3f normal(random.NextFloat() - 0.5f,
                                 random.NextFloat() - 0.5f,
                                 0.5f + random.NextFloat());
    Eigen::Vector3f directions[4];
    float depth[4];
    for (int k = 0; k < 4; ++k) {
      directions[k] = {0.5f * random.NextFloat(), 0.5f * random.NextFloat(), 1};
      depth[k] = 1.0f / normal.dot(directions[k]);
    }
    float d_depth[4];
    EXPECT_LT(EvaluateTripleProduct(directions, depth, d_depth), 1e-5);
  }
}

TEST(EvaluateTripleProduct, GradientIsThatOfTheFormula) {
  Random random(2);
  for (int round = 0; round < 300; ++round) {
    Eigen::Vector3f directions[4];
    float depth[4];
    for (int k = 0; k < 4; ++k) {
      directions[k] = {random.NextFloat() - 0.5f, random.NextFloat() - 0.5f, 1};
      depth[k] = 1 + random.NextFloat();
    }
    const auto reference = [&](const std::vector<double>& at) {
      Eigen::Matrix3d edges;
      const Eigen::Vector3d a = at[0] * directions[0].cast<double>();
      for (int k = 1; k < 4; ++k) {
        edges.col(k - 1) = at[k] * directions[k].cast<double>() - a;
      }
      return std::abs(edges.determinant());
    };
    float d_depth[4];
    const float loss = EvaluateTripleProduct(directions, depth, d_depth);
    const std::vector<double> exact(depth, depth + 4);
    EXPECT_NEAR(loss, reference(exact), 1e-5);
    if (loss < 1e-4) {
      continue;  // the kink
    }
    const std::vector<double> expected = NumericGradient(reference, exact);
    for (int k = 0; k < 4; ++k) {
      EXPECT_NEAR(d_depth[k], expected[k], 1e-4 * (1 + std::abs(expected[k])));
    }
  }
}

TEST(EvaluateTripleProduct, IsCubicInTheUnit) {
  Eigen::Vector3f directions[4] = {
      {0.1f, 0, 1}, {0.6f, 0.1f, 1}, {0, 0.5f, 1}, {-0.4f, -0.3f, 1}};
  const float depth[4] = {1, 1.5f, 2, 1.2f};
  float d_depth[4];
  const float loss = EvaluateTripleProduct(directions, depth, d_depth);
  for (Eigen::Vector3f& direction : directions) {
    direction *= 2;
  }
  EXPECT_NEAR(
      EvaluateTripleProduct(directions, depth, d_depth), 8 * loss, 1e-4);
}

}  // namespace
}  // namespace structnerf
