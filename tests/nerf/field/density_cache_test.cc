#include "nerf/field/density_cache.h"

#include <cmath>
#include <limits>
#include <set>
#include <vector>

#include <gtest/gtest.h>

namespace structnerf {
namespace {

const Eigen::Vector3f kExtent(1.0f, 0.63f, 0.31f);

struct Points {
  explicit Points(const size_t count) : x(count), y(count), z(count) {}
  std::vector<float> x;
  std::vector<float> y;
  std::vector<float> z;
};

Points Visit(DensityCache* cache, const size_t count) {
  Points points(count);
  cache->VisitPoints(cache->NextVisits(count),
                     count,
                     points.x.data(),
                     points.y.data(),
                     points.z.data());
  return points;
}

size_t CellOf(const DensityCache& cache, const Points& points, const size_t i) {
  const float scale = cache.CellsPerUnit();
  return cache.CellIndex(static_cast<int>(points.x[i] * scale),
                         static_cast<int>(points.y[i] * scale),
                         static_cast<int>(points.z[i] * scale));
}

float LogDensity(const DensityCache& cache, const size_t index) {
  return cache.Data()[index] / DensityCache::kLevelsPerUnit +
         DensityCache::kMinLogDensity;
}

TEST(DensityCache, CoversTheBox) {
  const DensityCache cache(16, kExtent, 1.0f);
  EXPECT_EQ(cache.Dimensions()[0], 16);
  EXPECT_EQ(cache.Dimensions()[1], 11);
  EXPECT_EQ(cache.Dimensions()[2], 5);
  EXPECT_EQ(cache.NumCells(), 16u * 11 * 5);
}

TEST(DensityCache, CellsHaveTheirOwnBytes) {
  const DensityCache cache(16, kExtent, 1.0f);
  std::set<size_t> indices;
  for (int z = 0; z < cache.Dimensions()[2]; ++z) {
    for (int y = 0; y < cache.Dimensions()[1]; ++y) {
      for (int x = 0; x < cache.Dimensions()[0]; ++x) {
        indices.insert(cache.CellIndex(x, y, z));
      }
    }
  }
  EXPECT_EQ(indices.size(), cache.NumCells());
  // Neighbours in a block share a cache line.
  EXPECT_EQ(cache.CellIndex(4, 4, 0) / 64, cache.CellIndex(7, 7, 3) / 64);
}

TEST(DensityCache, StartsWithTheInitialDensity) {
  for (const float density : {0.1f, 1.0f, 50.0f}) {
    const DensityCache cache(8, kExtent, density);
    EXPECT_NEAR(LogDensity(cache, cache.CellIndex(7, 5, 2)),
                std::log(density),
                1.0f / DensityCache::kLevelsPerUnit);
  }
}

TEST(DensityCache, VisitsEveryCellOnce) {
  for (const int resolution : {1, 7, 16}) {
    DensityCache cache(resolution, kExtent, 1.0f);
    for (int round = 0; round < 3; ++round) {
      std::set<size_t> cells;
      // In uneven parts.
      size_t left = cache.NumCells();
      while (left > 0) {
        const size_t count = std::min<size_t>(left, 13);
        const Points points = Visit(&cache, count);
        for (size_t i = 0; i < count; ++i) {
          cells.insert(CellOf(cache, points, i));
        }
        left -= count;
      }
      EXPECT_EQ(cells.size(), cache.NumCells());
    }
  }
}

TEST(DensityCache, VisitsOtherPointsInTheNextRound) {
  DensityCache cache(8, kExtent, 1.0f);
  const Points first = Visit(&cache, cache.NumCells());
  const Points second = Visit(&cache, cache.NumCells());
  for (size_t i = 0; i < cache.NumCells(); ++i) {
    EXPECT_EQ(CellOf(cache, first, i), CellOf(cache, second, i));
  }
  EXPECT_NE(first.x, second.x);
}

TEST(DensityCache, UpdateAnswersTheVisit) {
  DensityCache cache(8, kExtent, 1.0f);
  Visit(&cache, 5);
  const size_t first = cache.NextVisits(2);
  Points points(2);
  cache.VisitPoints(
      first, 2, points.x.data(), points.y.data(), points.z.data());
  const float log_density[] = {3.0f, 5.0f};
  cache.Update(first, log_density, 2, 0.9f);
  for (size_t i = 0; i < 2; ++i) {
    EXPECT_NEAR(
        LogDensity(cache, CellOf(cache, points, i)), log_density[i], 0.07f);
  }
}

TEST(DensityCache, RisesAtOnceAndFallsSlowly) {
  DensityCache cache(8, kExtent, 1.0f);
  const float position[] = {0.3f, 0.2f, 0.1f};
  const size_t cell = cache.CellIndex(2, 1, 0);
  const auto observe = [&](const float log_density, const float decay) {
    cache.Observe(
        &position[0], &position[1], &position[2], &log_density, 1, decay);
    return LogDensity(cache, cell);
  };
  EXPECT_NEAR(observe(4.0f, 0.5f), 4.0f, 0.07f);
  EXPECT_NEAR(observe(0.0f, 0.5f), 2.0f, 0.07f);
  EXPECT_NEAR(observe(0.0f, 0.5f), 1.0f, 0.07f);
  EXPECT_NEAR(observe(0.0f, 1.0f), 1.0f, 0.07f);
  // However slow, it arrives.
  for (int i = 0; i < 100; ++i) {
    observe(0.0f, 0.98f);
  }
  EXPECT_NEAR(observe(0.0f, 0.98f), 0.0f, 0.07f);
}

TEST(DensityCache, KeepsWithinTheBoxAndTheByte) {
  DensityCache cache(8, kExtent, 1.0f);
  const float infinity = std::numeric_limits<float>::infinity();
  const float x[] = {-5.0f, 5.0f, 0.99f};
  const float y[] = {-5.0f, 5.0f, 0.6f};
  const float z[] = {-5.0f, 5.0f, 0.3f};
  const float log_density[] = {
      infinity, -infinity, std::numeric_limits<float>::quiet_NaN()};
  cache.Observe(x, y, z, log_density, 3, 0.0f);
  EXPECT_EQ(cache.Data()[cache.CellIndex(0, 0, 0)], 255);
  EXPECT_EQ(cache.Data()[cache.CellIndex(7, 5, 2)], 0);
}

TEST(DensityCache, ClearForgetsEverything) {
  DensityCache cache(8, kExtent, 10.0f);
  const Points first = Visit(&cache, 7);
  cache.Clear();
  for (size_t i = 0; i < 7; ++i) {
    EXPECT_EQ(cache.Data()[CellOf(cache, first, i)], 0);
  }
  EXPECT_EQ(Visit(&cache, 7).x, first.x);
}

}  // namespace
}  // namespace structnerf
