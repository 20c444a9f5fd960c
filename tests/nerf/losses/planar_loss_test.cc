#include "nerf/losses/planar_loss.h"

#include "nerf/util/random.h"
#include "tests/support/numeric_gradient.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

namespace structnerf {
namespace {

// The documented formula in double precision.
double ReferenceLoss(const PlanarGroup& group,
                     const std::vector<double>& depth) {
  double mean = 0;
  double difference = 1 / depth[3];
  for (int i = 0; i < 4; ++i) {
    mean += 0.25 / depth[i];
    difference -= i < 3 ? group.barycentric[i] / depth[i] : 0;
  }
  const double residual = std::abs(difference / mean);
  return residual < 0.01 ? 0.5 * residual * residual / 0.01 : residual - 0.005;
}

// Pixels (0, 0), (10, 0), (0, 20) and the middle of the last two.
PlanarGroup MiddleOfAnEdge() {
  const float x[] = {0, 10, 0, 5};
  const float y[] = {0, 0, 20, 10};
  PlanarGroup group;
  EXPECT_TRUE(MakePlanarGroup(x, y, &group));
  return group;
}

TEST(MakePlanarGroup, BarycentricCoordinates) {
  const PlanarGroup group = MiddleOfAnEdge();
  EXPECT_NEAR(group.barycentric[0], 0, 1e-6);
  EXPECT_NEAR(group.barycentric[1], 0.5, 1e-6);
  EXPECT_NEAR(group.barycentric[2], 0.5, 1e-6);

  // Outside the triangle: (1, 1) - (0, 0) = 0.1 u + 0.05 v.
  const float x[] = {0, 10, 0, -5};
  const float y[] = {0, 0, 20, 1};
  PlanarGroup outside;
  ASSERT_TRUE(MakePlanarGroup(x, y, &outside));
  EXPECT_NEAR(outside.barycentric[0], 1.45, 1e-6);
  EXPECT_NEAR(outside.barycentric[1], -0.5, 1e-6);
  EXPECT_NEAR(outside.barycentric[2], 0.05, 1e-6);
}

TEST(MakePlanarGroup, DegenerateTrianglesAreRefused) {
  PlanarGroup group;
  const auto make = [&](const std::vector<float>& x,
                        const std::vector<float>& y) {
    return MakePlanarGroup(x.data(), y.data(), &group);
  };
  EXPECT_FALSE(make({3, 3, 3, 3}, {4, 4, 4, 4}));           // one pixel
  EXPECT_FALSE(make({3, 3, 9, 5}, {4, 4, 4, 7}));           // two equal
  EXPECT_FALSE(make({0, 10, 20, 5}, {0, 10, 20, 9}));       // on a line
  EXPECT_FALSE(make({0, 100, 200, 100}, {0, 1, 0, 0.4f}));  // almost
  EXPECT_FALSE(make({0, 10, 0, 25}, {0, 0, 10, 0}));        // extrapolates far
  EXPECT_FALSE(make({0, 10, 0, 19}, {0, 0, 10, 19}));
  EXPECT_TRUE(make({0, 10, 0, 14}, {0, 0, 10, 14}));
}

TEST(EvaluatePlanarLoss, ByHand) {
  const PlanarGroup group = MiddleOfAnEdge();
  float d_depth[4];

  // Inverse depths 1, 0.5, 0.5 and 1 instead of 0.5: r = 0.5 / 0.75.
  const float far_off[] = {1, 2, 2, 1};
  EXPECT_NEAR(
      EvaluatePlanarLoss(group, far_off, d_depth), 0.5 / 0.75 - 0.005, 1e-6);
  // dr/drho_3 = (1 - r / 4) / mean and drho/ddepth = -1 / depth^2.
  EXPECT_NEAR(d_depth[3], -(1 - 1 / 6.0) / 0.75, 1e-5);
  EXPECT_NEAR(d_depth[0], (1 / 6.0) / 0.75, 1e-5);
  EXPECT_NEAR(d_depth[1], 0.25 * (0.5 + 1 / 6.0) / 0.75, 1e-5);
  EXPECT_NEAR(d_depth[2], d_depth[1], 1e-6);

  // 0.4 % off: quadratic.
  const float near_by[] = {1, 1, 1, 1 / 1.004f};
  EXPECT_NEAR(EvaluatePlanarLoss(group, near_by, d_depth),
              0.5 * std::pow(0.004 / 1.001, 2) / 0.01,
              1e-6);
}

TEST(EvaluatePlanarLoss, ZeroOnPlanesAtAnyScale) {
  Random random(1);
  int num_groups = 0;
  for (int round = 0; round < 2000; ++round) {
    float x[4];
    float y[4];
    for (int i = 0; i < 4; ++i) {
      x[i] = 320 * random.NextFloat();
      y[i] = 240 * random.NextFloat();
    }
    PlanarGroup group;
    if (!MakePlanarGroup(x, y, &group)) {
      continue;
    }
    ++num_groups;
    // A slanted plane: inverse depth affine in pixels, doubling over the image.
    const double by_x = (random.NextFloat() - 0.5) / 320;
    const double by_y = (random.NextFloat() - 0.5) / 240;
    for (const double scale : {1e-6, 1e-3, 1.0, 1e3, 1e6}) {
      float depth[4];
      for (int i = 0; i < 4; ++i) {
        depth[i] = static_cast<float>(scale / (1 + by_x * x[i] + by_y * y[i]));
      }
      float d_depth[4];
      EXPECT_LT(EvaluatePlanarLoss(group, depth, d_depth), 1e-9);
      for (const float derivative : d_depth) {
        EXPECT_LT(std::abs(derivative * scale), 2e-3);
      }
    }
  }
  EXPECT_GT(num_groups, 1000);
}

TEST(EvaluatePlanarLoss, DoesNotDependOnScale) {
  const PlanarGroup group = MiddleOfAnEdge();
  const double depth[] = {1.1, 1.9, 2.3, 1.7};
  float expected_d_depth[4];
  float expected = 0;
  for (const double scale : {1.0, 1e-6, 1e6}) {
    float scaled[4];
    for (int i = 0; i < 4; ++i) {
      scaled[i] = static_cast<float>(scale * depth[i]);
    }
    float d_depth[4];
    const float loss = EvaluatePlanarLoss(group, scaled, d_depth);
    if (scale == 1.0) {
      expected = loss;
      std::copy(d_depth, d_depth + 4, expected_d_depth);
    }
    EXPECT_NEAR(loss, expected, 1e-5 * expected);
    for (int i = 0; i < 4; ++i) {
      EXPECT_NEAR(scale * d_depth[i], expected_d_depth[i], 1e-4);
    }
  }
}

TEST(EvaluatePlanarLoss, GradientIsThatOfTheFormula) {
  Random random(2);
  int num_quadratic = 0;
  for (int round = 0; round < 1000; ++round) {
    PlanarGroup group;
    group.barycentric[1] = 3 * random.NextFloat() - 1;
    group.barycentric[2] = 3 * random.NextFloat() - 1;
    group.barycentric[0] = 1 - group.barycentric[1] - group.barycentric[2];
    // Half of them close to a plane, in the quadratic part.
    const double spread = round % 2 == 0 ? 2.0 : 0.004;
    float depth[4];
    for (float& d : depth) {
      d = static_cast<float>(1.5 + spread * (random.NextFloat() - 0.5));
    }
    const std::vector<double> exact(depth, depth + 4);
    float d_depth[4];
    const float loss = EvaluatePlanarLoss(group, depth, d_depth);
    EXPECT_NEAR(loss, ReferenceLoss(group, exact), 1e-5 * (1 + loss));
    num_quadratic += loss < 0.005;
    const std::vector<double> expected = NumericGradient(
        [&](const std::vector<double>& at) { return ReferenceLoss(group, at); },
        exact);
    for (int i = 0; i < 4; ++i) {
      EXPECT_NEAR(d_depth[i], expected[i], 1e-3 * (1 + std::abs(expected[i])));
    }
  }
  EXPECT_GT(num_quadratic, 300);
}

}  // namespace
}  // namespace structnerf
