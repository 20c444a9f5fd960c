#include "nerf/engine/hierarchical_sampling.h"

#include <algorithm>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace structnerf {
namespace {

using testing::ElementsAre;
using testing::FloatNear;

// As documented, and from 1 to 5.
void ExpectValid(const RayPoints& points, const size_t count) {
  ASSERT_EQ(points.depth.size(), count);
  ASSERT_EQ(points.edges.size(), count + 1);
  EXPECT_FLOAT_EQ(points.edges.front(), 1);
  EXPECT_FLOAT_EQ(points.edges.back(), 5);
  EXPECT_TRUE(std::is_sorted(points.edges.begin(), points.edges.end()));
  for (size_t i = 0; i < count; ++i) {
    EXPECT_GE(points.depth[i], points.edges[i]);
    EXPECT_LE(points.depth[i], points.edges[i + 1]);
  }
}

TEST(MlpBatchSize, IsWholeTilesAndOneAtLeast) {
  SamplingOptions sampling;
  sampling.num_samples = 8;
  sampling.num_fine_samples = 16;
  EXPECT_EQ(MlpBatchSize(sampling).num_tiles, 16u);
  EXPECT_EQ(MlpBatchSize(sampling).num_points, 16384u);
  sampling.num_fine_samples = 1024;
  EXPECT_EQ(MlpBatchSize(sampling).num_tiles, 1u);
  EXPECT_EQ(MlpBatchSize(sampling).num_points, 32u * 1040);
}

TEST(StratifiedPoints, AreInTheMiddleUnlessJittered) {
  EXPECT_THAT(StratifiedPoints(1, 5, 4, nullptr).depth,
              ElementsAre(1.5f, 2.5f, 3.5f, 4.5f));
  Random random(1);
  double sum = 0;
  for (int round = 0; round < 1000; ++round) {
    const RayPoints points = StratifiedPoints(1, 5, 4, &random);
    ExpectValid(points, 4);
    sum += points.depth[2];
  }
  EXPECT_NEAR(sum / 1000, 3.5, 0.05);
}

TEST(RefinedPoints, FollowTheLight) {
  const RayPoints coarse = StratifiedPoints(1, 5, 4, nullptr);
  // A quarter ends in [2, 3), the rest in [4, 5).
  const float weight[] = {0, 0.25f, 0, 0.75f};
  const RayPoints points = RefinedPoints(coarse, weight, 8, 0, 0, nullptr);
  ExpectValid(points, 12);
  EXPECT_THAT(points.depth,
              ElementsAre(1.5f,
                          FloatNear(2.25f, 1e-3f),
                          2.5f,
                          FloatNear(2.75f, 1e-3f),
                          3.5f,
                          FloatNear(4 + 1.0f / 12, 1e-3f),
                          FloatNear(4 + 3.0f / 12, 1e-3f),
                          FloatNear(4 + 5.0f / 12, 1e-3f),
                          4.5f,
                          FloatNear(4 + 7.0f / 12, 1e-3f),
                          FloatNear(4 + 9.0f / 12, 1e-3f),
                          FloatNear(4 + 11.0f / 12, 1e-3f)));
}

TEST(RefinedPoints, NoLightIsSampledEvenly) {
  const RayPoints coarse = StratifiedPoints(1, 5, 4, nullptr);
  const float weight[] = {0, 0, 0, 0};
  const RayPoints points = RefinedPoints(coarse, weight, 4, 0, 0, nullptr);
  ExpectValid(points, 8);
  EXPECT_NEAR(points.depth[0], 1.5f, 1e-4);
  EXPECT_NEAR(points.depth[7], 4.5f, 1e-4);
}

TEST(RefinedPoints, JitterStaysWithinTheShares) {
  Random random(2);
  for (int round = 0; round < 1000; ++round) {
    const RayPoints coarse = StratifiedPoints(1, 5, 6, &random);
    std::vector<float> weight;
    for (int i = 0; i < 6; ++i) {
      weight.push_back(random.NextFloat() < 0.5f ? 0 : random.NextFloat());
    }
    ExpectValid(RefinedPoints(coarse, weight.data(), 16, 0, 0, &random), 22);
  }
}

TEST(RefinedPoints, HalfGatherAroundTheGuide) {
  Random random(3);
  const RayPoints coarse = StratifiedPoints(1, 5, 4, nullptr);
  const float weight[] = {1, 0, 0, 0};
  const RayPoints points = RefinedPoints(coarse, weight, 200, 4, 0.1f, &random);
  ExpectValid(points, 204);
  const auto count = [&](const float begin, const float end) {
    return std::count_if(points.depth.begin(),
                         points.depth.end(),
                         [&](const float z) { return z >= begin && z < end; });
  };
  EXPECT_NEAR(count(1, 2), 101, 1);
  EXPECT_NEAR(count(3.9f, 4.1f), 68, 20);  // within one deviation
  EXPECT_NEAR(count(3.6f, 4.4f), 100, 1);
  // Rendering knows no guide.
  EXPECT_EQ(RefinedPoints(coarse, weight, 8, 4, 0.1f, nullptr).depth,
            RefinedPoints(coarse, weight, 8, 0, 0, nullptr).depth);
}

}  // namespace
}  // namespace structnerf
