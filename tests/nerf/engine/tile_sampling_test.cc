#include "nerf/engine/tile_sampling.h"

#include "nerf/field/field_layout.h"
#include "tests/nerf/engine/random_scene.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

namespace structnerf {
namespace {

constexpr int kNumRays = 9;

struct Samples {
  Samples(const RayTile& rays, const int num_samples, Random* random)
      : edges(rays.num_rays * (num_samples + 1)),
        x(rays.num_rays * num_samples),
        y(x.size()),
        z(x.size()) {
    const DensityCache cache(16, Eigen::Vector3f::Ones(), 1.0f);
    RaySamplingParameters parameters;
    parameters.num_samples = num_samples;
    SampleTile(rays,
               cache,
               parameters,
               random,
               edges.data(),
               x.data(),
               y.data(),
               z.data());
  }

  std::vector<float> edges;
  std::vector<float> x;
  std::vector<float> y;
  std::vector<float> z;
};

// z-depth of a sample, seen along the ray's longest direction.
float DepthOf(const RayTile& rays,
              const int ray,
              const float x,
              const float y,
              const float z) {
  const float position[3] = {x, y, z};
  int axis = 0;
  for (int i = 1; i < 3; ++i) {
    if (std::abs(rays.direction[i][ray]) >
        std::abs(rays.direction[axis][ray])) {
      axis = i;
    }
  }
  return (position[axis] - rays.origin[axis][ray]) / rays.direction[axis][ray];
}

TEST(TileSampling, PointsLieInTheirIntervals) {
  const RayTile rays = RandomRays(1, 0, 0, kNumRays);
  for (const int num_samples : {1, 2, 16, 64}) {
    for (const bool jittered : {false, true}) {
      Random random(2);
      const Samples samples(rays, num_samples, jittered ? &random : nullptr);
      for (int ray = 0; ray < kNumRays; ++ray) {
        for (int i = 0; i < num_samples; ++i) {
          const int s = ray * num_samples + i;
          const float* const edges =
              samples.edges.data() + ray * (num_samples + 1) + i;
          const float depth =
              DepthOf(rays, ray, samples.x[s], samples.y[s], samples.z[s]);
          EXPECT_GE(depth, edges[0] - 1e-5f);
          EXPECT_LE(depth, edges[1] + 1e-5f);
          if (!jittered) {
            EXPECT_NEAR(depth, 0.5f * (edges[0] + edges[1]), 1e-5);
          }
        }
      }
    }
  }
}

TEST(TileSampling, DependsOnTheNumbersOnly) {
  const RayTile rays = RandomRays(1, 0, 0, kNumRays);
  Random first_random(3, 1, 2);
  Random second_random(3, 1, 2);
  Random other_random(3, 1, 3);
  const Samples first(rays, 16, &first_random);
  const Samples second(rays, 16, &second_random);
  const Samples other(rays, 16, &other_random);
  EXPECT_EQ(first.x, second.x);
  EXPECT_EQ(first.edges, second.edges);
  EXPECT_NE(first.x, other.x);
  EXPECT_NE(first.edges, other.edges);
}

// Columns of an orthonormal basis: the mean of the product of two over the
// sphere is 1 / (4 pi) or zero.
TEST(TileSampling, DirectionsAreEncodedInAnOrthonormalBasis) {
  constexpr int kSteps = 200;
  std::vector<double> product(kDirectionWidth * kDirectionWidth);
  for (int i = 0; i < kSteps; ++i) {
    for (int j = 0; j < kSteps; ++j) {
      const double cosine = -1 + 2 * (i + 0.5) / kSteps;
      const double sine = std::sqrt(1 - cosine * cosine);
      const double angle = 2 * M_PI * (j + 0.5) / kSteps;
      constexpr float kNorm = 1.3f;
      RayTile rays;
      rays.num_rays = 1;
      rays.direction[0][0] = static_cast<float>(kNorm * sine * std::cos(angle));
      rays.direction[1][0] = static_cast<float>(kNorm * sine * std::sin(angle));
      rays.direction[2][0] = static_cast<float>(kNorm * cosine);
      rays.direction_norm[0] = kNorm;
      float encoding[kDirectionWidth];
      EncodeDirection(rays, 0, kMaxNumHarmonics, encoding);
      for (int a = 0; a < kDirectionWidth; ++a) {
        for (int b = 0; b < kDirectionWidth; ++b) {
          product[a * kDirectionWidth + b] +=
              encoding[a] * encoding[b] * 4 * M_PI / (kSteps * kSteps);
        }
      }
    }
  }
  for (int a = 0; a < kDirectionWidth; ++a) {
    for (int b = 0; b < kDirectionWidth; ++b) {
      EXPECT_NEAR(product[a * kDirectionWidth + b],
                  a == b && a < kMaxNumHarmonics ? 1 : 0,
                  1e-3);
    }
  }
}

TEST(TileSampling, HarmonicsOfHigherDegreesAreLeftOut) {
  const RayTile rays = RandomRays(4, 0, 0, 1);
  float all[kDirectionWidth];
  EncodeDirection(rays, 0, kMaxNumHarmonics, all);
  for (const int num_harmonics : {1, 4}) {
    float some[kDirectionWidth];
    EncodeDirection(rays, 0, num_harmonics, some);
    for (int i = 0; i < kDirectionWidth; ++i) {
      EXPECT_EQ(some[i], i < num_harmonics ? all[i] : 0.0f);
    }
  }
}

TEST(TileSampling, HalfOfTheEdgesGatherAroundTheGuide) {
  RayTile rays = RandomRays(4, 0, 0, kNumRays);
  rays.is_guided = true;
  for (int ray = 0; ray < kNumRays; ++ray) {
    const float length = rays.far[ray] - rays.near[ray];
    // The first ray has no guide, the last one's is off its end.
    rays.guide_depth[ray] =
        ray == 0 ? 0.0f
                 : rays.near[ray] + (ray + 1 == kNumRays ? 2 : 0.6f) * length;
    rays.guide_deviation[ray] = 0.01f * length;
  }
  constexpr int kNumSamples = 33;
  const auto count_near = [&](const Samples& samples, const int ray) {
    int count = 0;
    for (int i = 1; i < kNumSamples; ++i) {
      const float edge = samples.edges[ray * (kNumSamples + 1) + i];
      count += std::abs(edge - rays.guide_depth[ray]) <
               4 * rays.guide_deviation[ray];
    }
    return count;
  };
  Random random(1);
  const Samples guided(rays, kNumSamples, &random);
  for (int ray = 0; ray < kNumRays; ++ray) {
    const auto begin = guided.edges.begin() + ray * (kNumSamples + 1);
    EXPECT_TRUE(std::is_sorted(begin, begin + kNumSamples + 1));
    EXPECT_EQ(begin[0], rays.near[ray]);
    EXPECT_EQ(begin[kNumSamples], rays.far[ray]);
    if (ray > 0 && ray + 1 < kNumRays) {
      EXPECT_GE(count_near(guided, ray), kNumSamples / 2);
    }
  }
  // Rendering is not guided, nor are rays of other tiles.
  const Samples rendered(rays, kNumSamples, nullptr);
  RayTile others = rays;
  others.is_guided = false;
  EXPECT_EQ(rendered.edges, Samples(others, kNumSamples, nullptr).edges);
  EXPECT_LT(count_near(rendered, 3), kNumSamples / 3);
}

}  // namespace
}  // namespace structnerf
