#include "nerf/planes/dominant_direction.h"

#include "nerf/util/random.h"

#include <cmath>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

namespace structnerf {
namespace {

// Uniform on the sphere.
Eigen::Vector3f AnyDirection(Random* random) {
  while (true) {
    const Eigen::Vector3f v(2 * random->NextFloat() - 1,
                            2 * random->NextFloat() - 1,
                            2 * random->NextFloat() - 1);
    if (v.norm() > 0.1f && v.norm() < 1) {
      return v.normalized();
    }
  }
}

std::vector<Eigen::Vector3f> UniformNormals(const size_t count) {
  Random random(3);
  std::vector<Eigen::Vector3f> normals;
  for (size_t i = 0; i < count; ++i) {
    normals.push_back(AnyDirection(&random));
  }
  return normals;
}

// Every `period`-th is near `direction`, within a few degrees; half of these
// point the other way. The others are uniform.
std::vector<Eigen::Vector3f> NoisyNormals(const Eigen::Vector3f& direction,
                                          const size_t count,
                                          const size_t period) {
  std::vector<Eigen::Vector3f> normals = UniformNormals(count);
  Random random(4);
  for (size_t i = 0; i < count; i += period) {
    const float sign = i / period % 2 == 0 ? 1.0f : -1.0f;
    normals[i] =
        sign * (direction + 0.05f * AnyDirection(&random)).normalized();
  }
  return normals;
}

float DegreesBetween(const Eigen::Vector3f& a, const Eigen::Vector3f& b) {
  const float sine = a.cross(b).norm();
  return std::atan2(sine, std::abs(a.dot(b))) * 180 / static_cast<float>(M_PI);
}

// Share of a sphere within 8 degrees of an axis.
const float kUniformShare = 1 - std::cos(8 * static_cast<float>(M_PI) / 180);

TEST(DominantDirection, IsFoundAmongNoise) {
  const Eigen::Vector3f truth = Eigen::Vector3f(0.3f, -0.8f, 0.2f).normalized();
  const DominantDirection result =
      FindDominantDirection(NoisyNormals(truth, 6000, 4));
  EXPECT_LT(DegreesBetween(result.direction, truth), 0.5f);
  EXPECT_NEAR(result.direction.norm(), 1, 1e-5);
  // A quarter, and its share of the others.
  EXPECT_NEAR(result.share, 0.25f + 0.75f * kUniformShare, 0.01);
}

TEST(DominantDirection, SignsOfTheNormalsDoNotMatter) {
  std::vector<Eigen::Vector3f> normals =
      NoisyNormals(Eigen::Vector3f::UnitY(), 2000, 3);
  const DominantDirection expected = FindDominantDirection(normals);
  for (size_t i = 0; i < normals.size(); i += 2) {
    normals[i] *= -1;
  }
  const DominantDirection result = FindDominantDirection(normals);
  EXPECT_LT(DegreesBetween(result.direction, expected.direction), 0.1f);
  EXPECT_EQ(result.share, expected.share);
}

TEST(DominantDirection, TheMoreCommonOfTwoWins) {
  std::vector<Eigen::Vector3f> normals;
  for (int i = 0; i < 100; ++i) {
    normals.push_back(i % 10 < 6 ? Eigen::Vector3f::UnitX()
                                 : Eigen::Vector3f::UnitZ());
  }
  const DominantDirection result = FindDominantDirection(normals);
  EXPECT_LT(DegreesBetween(result.direction, Eigen::Vector3f::UnitX()), 0.01f);
  EXPECT_FLOAT_EQ(result.share, 0.6f);
}

// More than are looked at.
TEST(DominantDirection, ShareIsRightForManyNormals) {
  const DominantDirection result =
      FindDominantDirection(NoisyNormals(Eigen::Vector3f::UnitZ(), 45001, 5));
  EXPECT_LT(DegreesBetween(result.direction, Eigen::Vector3f::UnitZ()), 0.5f);
  EXPECT_NEAR(result.share, 0.2f + 0.8f * kUniformShare, 0.015);
}

TEST(DominantDirection, UniformNormalsHaveASmallShare) {
  const DominantDirection result = FindDominantDirection(UniformNormals(8000));
  EXPECT_NEAR(result.direction.norm(), 1, 1e-5);
  EXPECT_GT(result.share, kUniformShare);
  EXPECT_LT(result.share, 2 * kUniformShare);
}

TEST(DominantDirection, OfOneNormalIsThatNormal) {
  const Eigen::Vector3f normal(0.6f, 0, 0.8f);
  const DominantDirection result = FindDominantDirection({normal});
  EXPECT_LT(DegreesBetween(result.direction, normal), 0.01f);
  EXPECT_EQ(result.share, 1);
}

TEST(DominantDirection, WithoutNormalsThereIsNone) {
  const DominantDirection result = FindDominantDirection({});
  EXPECT_EQ(result.direction, Eigen::Vector3f::Zero());
  EXPECT_EQ(result.share, 0);
}

}  // namespace
}  // namespace structnerf
