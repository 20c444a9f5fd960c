#include "nerf/extract/confidence.h"

#include "nerf/extract/map_resolution.h"
#include "tests/nerf/aborting_progress.h"
#include "tests/nerf/plane_scene.h"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

namespace structnerf {
namespace {

constexpr int kWidth = 40;
constexpr int kHeight = 30;

DenseMaps ConstantDepth(const float depth) {
  DenseMaps maps;
  maps.width = kWidth;
  maps.height = kHeight;
  maps.depth.assign(kWidth * kHeight, depth);
  return maps;
}

std::vector<float> ConstantAngle(const float angle) {
  return std::vector<float>(kWidth * kHeight, angle);
}

std::vector<float> Estimate(const PinholeCamera& camera,
                            const DenseMaps& maps,
                            const std::vector<float>& angles,
                            const bool is_matched = false) {
  ThreadPool pool(2);
  Progress progress;
  return EstimateConfidence(
      camera, maps.depth, angles, is_matched, &pool, &progress);
}

// Of one pixel at depth 2 of a wall, its mean being of so many depths.
float ConfidenceOfMean(const int num_depths, const float spread) {
  DepthAgreement agreement;
  agreement.num_depths.assign(kWidth * kHeight, num_depths);
  agreement.spread.assign(kWidth * kHeight, spread);
  ThreadPool pool(2);
  Progress progress;
  return EstimateConfidence(MakeCamera(kWidth, kHeight, 50),
                            ConstantDepth(2).depth,
                            agreement,
                            &pool,
                            &progress)[15 * kWidth + 20];
}

// A flat pixel that a view confirms under ten degrees, and one at a slope of 3
// that one confirms under three, as the fit to two rooms has them.
TEST(EstimateConfidence, IsWhatWasFitted) {
  const PinholeCamera camera = MakeCamera(kWidth, kHeight, 50);
  DenseMaps maps = ConstantDepth(2);
  const size_t pixel = 15 * kWidth + 20;
  EXPECT_NEAR(Estimate(camera, maps, ConstantAngle(10))[pixel], 0.863, 0.001);
  EXPECT_NEAR(
      Estimate(camera, maps, ConstantAngle(10), /*is_matched=*/true)[pixel],
      0.920,
      0.001);
  for (int row = 0; row < kHeight; ++row) {
    for (int col = 0; col < kWidth; ++col) {
      maps.depth[row * kWidth + col] += 0.12f * (col - 20);
    }
  }
  EXPECT_NEAR(Estimate(camera, maps, ConstantAngle(3))[pixel], 0.464, 0.001);
}

TEST(EstimateConfidence, GrowsWithTheAngle) {
  const PinholeCamera camera = MakeCamera(kWidth, kHeight, 50);
  const DenseMaps maps = ConstantDepth(2);
  float last = 0;
  for (const float angle : {1.0f, 3.0f, 10.0f, 30.0f}) {
    const float confidence =
        Estimate(camera, maps, ConstantAngle(angle))[15 * kWidth];
    EXPECT_GT(confidence, last + 0.02f);
    EXPECT_LT(confidence, 1);
    last = confidence;
  }
  // No view confirms it.
  EXPECT_EQ(Estimate(camera, maps, ConstantAngle(0))[0],
            Estimate(camera, maps, ConstantAngle(1))[0]);
}

TEST(EstimateConfidence, EdgesAreUncertain) {
  const PinholeCamera camera = MakeCamera(kWidth, kHeight, 50);
  DenseMaps maps = ConstantDepth(2);
  for (int row = 0; row < kHeight; ++row) {
    for (int col = 20; col < kWidth; ++col) {
      maps.depth[row * kWidth + col] = 3;
    }
  }
  const auto confidence = Estimate(camera, maps, ConstantAngle(10));
  EXPECT_LT(confidence[15 * kWidth + 19] + 0.2f, confidence[15 * kWidth + 18]);
  EXPECT_LT(confidence[15 * kWidth + 20] + 0.2f, confidence[15 * kWidth + 21]);
}

TEST(EstimateConfidence, DoesNotDependOnScaleOrResolution) {
  DenseMaps maps = ConstantDepth(2);
  DenseMaps scaled = ConstantDepth(2);
  DenseMaps finer = ConstantDepth(2);
  for (int row = 0; row < kHeight; ++row) {
    for (int col = 0; col < kWidth; ++col) {
      const size_t pixel = row * kWidth + col;
      maps.depth[pixel] += 0.1f * col;
      scaled.depth[pixel] = 1000 * maps.depth[pixel];
      // The same slope around the first rows, on half as large pixels.
      finer.depth[pixel] = 2 + 0.05f * (col + 20);
    }
  }
  const size_t middle = 15 * kWidth + 20;
  const float confidence =
      Estimate(MakeCamera(kWidth, kHeight, 50), maps, ConstantAngle(5))[middle];
  EXPECT_NEAR(
      Estimate(
          MakeCamera(kWidth, kHeight, 50), scaled, ConstantAngle(5))[middle],
      confidence,
      1e-5);
  EXPECT_NEAR(
      Estimate(
          MakeCamera(kWidth, kHeight, 100), finer, ConstantAngle(5))[middle],
      confidence,
      1e-5);
}

// Twice as many pixels than the reference size make an edge two pixels wide.
TEST(EstimateConfidence, EdgesAreAsWideInAnyResolution) {
  DenseMaps maps;
  maps.width = 2 * kReferenceMapSize;
  maps.height = 1;
  maps.depth.assign(maps.width, 2.0f);
  std::fill(maps.depth.begin() + 100, maps.depth.end(), 3.0f);
  const auto confidence = Estimate(MakeCamera(maps.width, maps.height, 500),
                                   maps,
                                   std::vector<float>(maps.width, 10.0f));
  for (int col = 90; col < 110; ++col) {
    const bool is_at_edge = col >= 98 && col < 102;
    EXPECT_EQ(confidence[col] < confidence[50] - 0.2f, is_at_edge) << col;
  }
}

TEST(EstimateConfidence, NoDepthHasNone) {
  DenseMaps maps = ConstantDepth(2);
  maps.depth[7] = 0;
  const auto confidence =
      Estimate(MakeCamera(kWidth, kHeight, 50), maps, ConstantAngle(10));
  EXPECT_EQ(confidence[7], 0);
  EXPECT_GT(confidence[6], 0);
}

// Masked pixels are no surface at depth 0.
TEST(EstimateConfidence, HolesAndBordersAreNoEdges) {
  DenseMaps maps = ConstantDepth(2);
  for (int row = 0; row < kHeight; ++row) {
    for (int col = 0; col < kWidth; ++col) {
      maps.depth[row * kWidth + col] += 0.02f * col;
    }
  }
  const PinholeCamera camera = MakeCamera(kWidth, kHeight, 50);
  const auto expected = Estimate(camera, maps, ConstantAngle(10));
  const size_t pixel = 15 * kWidth + 20;
  for (const int neighbor : {-1, 1, -kWidth, kWidth}) {
    DenseMaps holed = maps;
    holed.depth[pixel + neighbor] = 0;
    const auto confidence = Estimate(camera, holed, ConstantAngle(10));
    EXPECT_NEAR(confidence[pixel], expected[pixel], 1e-5) << neighbor;
  }
  // Depth differs from column to column by the same, relative to it by less.
  EXPECT_NEAR(expected[0], expected[2], 0.01);
  EXPECT_NEAR(expected[kWidth - 1], expected[kWidth - 3], 0.01);
}

TEST(EstimateConfidence, PixelsOnTheirOwnAreUncertain) {
  DenseMaps maps = ConstantDepth(2);
  const size_t pixel = 15 * kWidth + 20;
  const PinholeCamera camera = MakeCamera(kWidth, kHeight, 50);
  const float among_others = Estimate(camera, maps, ConstantAngle(10))[pixel];
  maps.depth.assign(maps.depth.size(), 0.0f);
  maps.depth[pixel] = 2;
  EXPECT_LT(Estimate(camera, maps, ConstantAngle(10))[pixel],
            among_others - 0.2f);
}

// On the flat, as the fit to two rooms has them: nothing known, a lone depth,
// and eight that are half a percent apart.
TEST(EstimateConfidence, IsWhatWasFittedToMeans) {
  EXPECT_NEAR(ConfidenceOfMean(0, 0), 0.631, 0.001);
  EXPECT_NEAR(ConfidenceOfMean(1, 0), 0.806, 0.001);
  EXPECT_NEAR(ConfidenceOfMean(8, 0.005f), 0.949, 0.001);
}

TEST(EstimateConfidence, GrowsWithDepthsThatAgree) {
  EXPECT_GT(ConfidenceOfMean(3, 0.01f), ConfidenceOfMean(2, 0.01f) + 0.02f);
  EXPECT_GT(ConfidenceOfMean(3, 0.01f), ConfidenceOfMean(3, 0.03f) + 0.1f);
}

TEST(EstimateConfidence, EndsWhenToldTo) {
  ThreadPool pool(1);
  AbortingProgress progress;
  EXPECT_THROW(EstimateConfidence(MakeCamera(kWidth, kHeight, 50),
                                  ConstantDepth(2).depth,
                                  ConstantAngle(5),
                                  /*is_matched=*/true,
                                  &pool,
                                  &progress),
               Aborted);
}

}  // namespace
}  // namespace structnerf
