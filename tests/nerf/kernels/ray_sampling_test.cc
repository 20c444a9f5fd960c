#include "nerf/kernels/ray_sampling.h"

#include "nerf/util/random.h"
#include "tests/nerf/random_values.h"
#include "tests/nerf/simd_targets.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <vector>

namespace structnerf {
namespace {

const Eigen::Vector3f kExtent(1.0f, 0.8f, 0.6f);

class RaySamplingTest : public SimdTargetTest {};

// A cache that holds a given density.
DensityCache MakeCache(
    const std::function<float(const Eigen::Vector3f&)>& log_density) {
  DensityCache cache(48, kExtent, 1.0f);
  cache.Clear();
  const size_t count = cache.NumCells();
  const size_t first = cache.NextVisits(count);
  std::vector<float> x(count);
  std::vector<float> y(count);
  std::vector<float> z(count);
  cache.VisitPoints(first, count, x.data(), y.data(), z.data());
  std::vector<float> values(count);
  for (size_t i = 0; i < count; ++i) {
    values[i] = log_density(Eigen::Vector3f(x[i], y[i], z[i]));
  }
  cache.Update(first, values.data(), count, 0.0f);
  return cache;
}

// Rays from the middle of the box, some of which leave it.
RayTile MakeRays(const int num_rays, const uint64_t seed) {
  Random random(seed);
  RayTile rays;
  rays.num_rays = num_rays;
  for (int ray = 0; ray < num_rays; ++ray) {
    Eigen::Vector3f direction(random.NextFloat() - 0.5f,
                              random.NextFloat() - 0.5f,
                              random.NextFloat() - 0.5f);
    direction.normalize();
    for (int axis = 0; axis < 3; ++axis) {
      rays.origin[axis][ray] = 0.5f * kExtent[axis];
      rays.direction[axis][ray] = 1.1f * direction[axis];
    }
    rays.direction_norm[ray] = 1.1f;
    rays.near[ray] = 0.02f + 0.05f * random.NextFloat();
    rays.far[ray] = 0.3f + random.NextFloat();
  }
  return rays;
}

PerRay<float> MakeJitter(const uint64_t seed) {
  PerRay<float> jitter;
  const auto values = RandomValues(jitter.size(), 0, 1, seed);
  std::copy(values.begin(), values.end(), jitter.begin());
  return jitter;
}

std::vector<float> Choose(const RayTile& rays,
                          const DensityCache& cache,
                          const RaySamplingParameters& parameters,
                          const PerRay<float>& jitter) {
  std::vector<float> edges(rays.num_rays * (parameters.num_samples + 1));
  ChooseIntervals(rays, cache, parameters, jitter, edges.data());
  return edges;
}

// What the header says, in plain code and double precision.
std::vector<double> ScalarEdges(const RayTile& rays,
                                const int ray,
                                const DensityCache& cache,
                                const RaySamplingParameters& parameters,
                                const float jitter) {
  const int num_bins = parameters.num_bins;
  const double near = rays.near[ray];
  const double far = rays.far[ray];
  const auto bin_edge = [&](const double b) {
    return near * std::pow(far / near, b / num_bins);
  };
  std::vector<double> cdf(num_bins + 1);
  double tau = 0;
  for (int b = 0; b < num_bins; ++b) {
    const double z = 0.5 * (bin_edge(b) + bin_edge(b + 1));
    int cell[3];
    for (int axis = 0; axis < 3; ++axis) {
      const double position =
          rays.origin[axis][ray] + z * rays.direction[axis][ray];
      cell[axis] = std::min(
          std::max(static_cast<int>(position * cache.CellsPerUnit()), 0),
          cache.Dimensions()[axis] - 1);
    }
    const double density =
        std::exp(cache.Data()[cache.CellIndex(cell[0], cell[1], cell[2])] /
                     static_cast<double>(DensityCache::kLevelsPerUnit) +
                 DensityCache::kMinLogDensity);
    tau += density * (bin_edge(b + 1) - bin_edge(b)) * rays.direction_norm[ray];
    cdf[b + 1] = 1 - std::exp(-tau);
  }
  const double absorbed = cdf[num_bins];
  for (int b = 0; b <= num_bins; ++b) {
    cdf[b] = (1 - parameters.uniform_share) * cdf[b] / absorbed +
             parameters.uniform_share * b / num_bins;
  }
  std::vector<double> edges = {near};
  for (int k = 1; k < parameters.num_samples; ++k) {
    const double target = (k - 1 + jitter) / (parameters.num_samples - 1);
    int b = 0;
    while (b + 1 < num_bins && cdf[b + 1] <= target) {
      ++b;
    }
    const double share = (target - cdf[b]) / (cdf[b + 1] - cdf[b]);
    edges.push_back(bin_edge(b) + share * (bin_edge(b + 1) - bin_edge(b)));
  }
  edges.push_back(far);
  return edges;
}

float ShellLogDensity(const Eigen::Vector3f& point) {
  const float radius = (point - 0.5f * kExtent).norm();
  return std::abs(radius - 0.25f) < 0.03f ? 6.0f : -4.0f;
}

// A field without sharp edges, so that rounding cannot put a bin's middle into
// a cell of quite another density.
float SmoothLogDensity(const Eigen::Vector3f& point) {
  return 2 * std::sin(6 * point.x()) + std::cos(9 * point.y() - point.z());
}

TEST_P(RaySamplingTest, AscendFromNearToFar) {
  const DensityCache caches[] = {
      MakeCache(ShellLogDensity),
      MakeCache([](const Eigen::Vector3f&) { return -10.0f; }),
      MakeCache([](const Eigen::Vector3f&) { return 12.0f; })};
  RaySamplingParameters parameters;
  for (const DensityCache& cache : caches) {
    for (const float uniform_share : {0.0f, 0.1f, 1.0f}) {
      parameters.uniform_share = uniform_share;
      for (int num_samples = 1; num_samples <= kMaxRaySamples; ++num_samples) {
        parameters.num_samples = num_samples;
        const RayTile rays = MakeRays(1 + num_samples % kMaxTileRays, 1);
        const auto edges =
            Choose(rays, cache, parameters, MakeJitter(num_samples));
        for (int ray = 0; ray < rays.num_rays; ++ray) {
          const float* const ray_edges = edges.data() + ray * (num_samples + 1);
          ASSERT_EQ(ray_edges[0], rays.near[ray]);
          ASSERT_EQ(ray_edges[num_samples], rays.far[ray]);
          ASSERT_TRUE(std::is_sorted(ray_edges, ray_edges + num_samples + 1));
        }
      }
    }
  }
}

TEST_P(RaySamplingTest, FollowsTheFormula) {
  const DensityCache cache = MakeCache(SmoothLogDensity);
  RaySamplingParameters parameters;
  parameters.uniform_share = 0.2f;
  for (const int num_bins : {8, 96, kMaxRayBins}) {
    for (const int num_samples : {2, 16, 37}) {
      parameters.num_bins = num_bins;
      parameters.num_samples = num_samples;
      const RayTile rays = MakeRays(kMaxTileRays, 3);
      const PerRay<float> jitter = MakeJitter(4);
      const auto edges = Choose(rays, cache, parameters, jitter);
      for (int ray = 0; ray < rays.num_rays; ++ray) {
        const auto expected =
            ScalarEdges(rays, ray, cache, parameters, jitter[ray]);
        for (int k = 0; k <= num_samples; ++k) {
          // A bin's middle on a cell border may be seen in either cell.
          ASSERT_NEAR(edges[ray * (num_samples + 1) + k], expected[k], 2e-3)
              << "ray " << ray << " edge " << k;
        }
      }
    }
  }
}

TEST_P(RaySamplingTest, ConcentratesOnADenseShell) {
  const DensityCache cache = MakeCache(ShellLogDensity);
  RaySamplingParameters parameters;
  parameters.num_samples = 32;
  parameters.uniform_share = 0.25f;
  const RayTile rays = MakeRays(kMaxTileRays, 5);
  const auto edges = Choose(rays, cache, parameters, MakeJitter(6));
  for (int ray = 0; ray < rays.num_rays; ++ray) {
    // Where the ray enters the shell, z-depth; one bin and one cell of slack.
    const float entry = 0.22f / rays.direction_norm[ray];
    if (rays.far[ray] < entry + 0.1f) {
      continue;
    }
    int num_near = 0;
    for (int k = 1; k < parameters.num_samples; ++k) {
      const float edge = edges[ray * (parameters.num_samples + 1) + k];
      num_near += std::abs(edge - entry) < 0.05f;
    }
    EXPECT_GE(num_near, 20);
  }
}

// Where nothing is known, bins are sampled evenly.
TEST_P(RaySamplingTest, EmptySpaceIsSampledEvenly) {
  DensityCache cache(16, kExtent, 1.0f);
  cache.Clear();
  // The lowest density the cache can tell is not quite none.
  RaySamplingParameters parameters;
  parameters.num_bins = 64;
  parameters.num_samples = 17;
  parameters.uniform_share = 0.0f;
  RayTile rays = MakeRays(1, 7);
  rays.near[0] = 1e-7f;
  rays.far[0] = 1e-6f;
  PerRay<float> jitter = {};
  const auto edges = Choose(rays, cache, parameters, jitter);
  for (int k = 1; k < 17; ++k) {
    const double expected = 1e-7 * std::pow(10.0, (k - 1) / 16.0);
    EXPECT_NEAR(edges[k] / expected, 1, 0.02);
  }
}

TEST_P(RaySamplingTest, RaysDoNotDependOnTheirNeighbours) {
  const DensityCache cache = MakeCache(SmoothLogDensity);
  const RaySamplingParameters parameters;
  const RayTile rays = MakeRays(kMaxTileRays, 8);
  const PerRay<float> jitter = MakeJitter(9);
  const auto all = Choose(rays, cache, parameters, jitter);
  for (const int num_rays : {1, 5, 16, 17}) {
    RayTile some = rays;
    some.num_rays = num_rays;
    // What is in the unused places must not matter.
    for (int ray = num_rays; ray < kMaxTileRays; ++ray) {
      some.near[ray] = std::numeric_limits<float>::quiet_NaN();
      some.origin[0][ray] = std::numeric_limits<float>::infinity();
    }
    const auto edges = Choose(some, cache, parameters, jitter);
    EXPECT_TRUE(std::equal(edges.begin(), edges.end(), all.begin()));
  }
}

STRUCTNERF_FOR_EACH_SIMD_TARGET(RaySamplingTest);

}  // namespace
}  // namespace structnerf
