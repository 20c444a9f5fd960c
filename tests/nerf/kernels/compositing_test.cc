#include "nerf/kernels/compositing.h"

#include "nerf/engine/ray_tile.h"
#include "tests/nerf/random_values.h"
#include "tests/nerf/simd_targets.h"
#include "tests/support/numeric_gradient.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace structnerf {
namespace {

constexpr size_t kStride = 3;

class CompositingTest : public SimdTargetTest {};

// f(tau) of the header and its derivative, in extended precision.
double WithinInterval(const double tau) {
  const long double t = tau;
  if (t < 1e-3L) {
    return static_cast<double>(0.5L - t / 12 + t * t * t / 720);
  }
  return static_cast<double>(1 / t - 1 / std::expm1(t));
}

double WithinIntervalDerivative(const double tau) {
  const long double t = tau;
  if (t < 1e-3L) {
    return static_cast<double>(-1.0L / 12 + t * t / 240);
  }
  // exp(t) / (exp(t) - 1)^2 in a form that does not overflow.
  const long double u = std::exp(-t);
  return static_cast<double>(u / ((1 - u) * (1 - u)) - 1 / (t * t));
}

// One ray in plain code.
struct ScalarRay {
  ScalarRay(const std::vector<double>& raw_density,
            const float* edges,
            const float ray_length) {
    const size_t n = raw_density.size();
    double sum = 0;
    for (size_t i = 0; i < n; ++i) {
      const double raw = std::min(
          std::max(raw_density[i], static_cast<double>(kMinRawDensity)),
          static_cast<double>(kMaxRawDensity));
      const double length = static_cast<double>(edges[i + 1]) - edges[i];
      const double tau = std::exp(raw) * length * ray_length;
      transmittance.push_back(std::exp(-sum));
      const bool is_last = i == n - 1;
      weight.push_back(transmittance[i] * (is_last ? 1.0 : -std::expm1(-tau)));
      z.push_back(edges[i] + length * (is_last ? 0.5 : WithinInterval(tau)));
      depth += weight[i] * z[i];
      sum += tau;
    }
    for (size_t i = 0; i < n; ++i) {
      variance += weight[i] * (z[i] - depth) * (z[i] - depth);
    }
    opacity = 1 - transmittance[n - 1];
  }

  std::vector<double> transmittance;
  std::vector<double> weight;
  std::vector<double> z;
  double depth = 0;
  double variance = 0;
  double opacity = 0;
};

// Rays with random intervals, of which some have no length, and densities.
struct Rays {
  Rays(const size_t num_rays,
       const size_t num_samples,
       const float min_raw,
       const float max_raw,
       const uint64_t seed)
      : num_rays(num_rays),
        n(num_samples),
        raw_density(
            RandomValues(num_rays * n * kStride, min_raw, max_raw, seed)),
        ray_length(RandomValues(num_rays, 1.0f, 1.5f, seed + 1)) {
    Random random(seed + 2);
    for (size_t ray = 0; ray < num_rays; ++ray) {
      float edge = 0.1f;
      edges.push_back(edge);
      for (size_t i = 0; i < n; ++i) {
        const bool is_empty = random.NextBelow(6) == 0;
        edge += is_empty ? 0.0f : random.NextFloat() / static_cast<float>(n);
        edges.push_back(edge);
      }
    }
    const size_t num_all = std::max<size_t>(num_rays * n, 1);
    tau.resize(num_all);
    transmittance.resize(num_all);
    weight.resize(num_all);
    z.resize(num_all);
    depth.resize(num_rays);
    variance.resize(num_rays);
    opacity.resize(num_rays);
  }

  CompositeInputs Inputs() const {
    CompositeInputs inputs;
    inputs.num_rays = num_rays;
    inputs.num_samples = n;
    inputs.raw_density = raw_density.data();
    inputs.raw_density_stride = kStride;
    inputs.edges = edges.data();
    inputs.ray_length = ray_length.data();
    return inputs;
  }

  CompositeSamples Samples() {
    return {tau.data(), transmittance.data(), weight.data(), z.data()};
  }

  void Forward() {
    CompositeForward(
        Inputs(), Samples(), depth.data(), variance.data(), opacity.data());
  }

  const float* Edges(const size_t ray) const {
    return edges.data() + ray * (n + 1);
  }

  std::vector<double> RawDensity(const size_t ray) const {
    std::vector<double> result(n);
    for (size_t i = 0; i < n; ++i) {
      result[i] = raw_density[(ray * n + i) * kStride];
    }
    return result;
  }

  ScalarRay Expected(const size_t ray) const {
    return ScalarRay(RawDensity(ray), Edges(ray), ray_length[ray]);
  }

  size_t num_rays;
  size_t n;
  std::vector<float> raw_density;
  std::vector<float> ray_length;
  std::vector<float> edges;
  std::vector<float> tau;
  std::vector<float> transmittance;
  std::vector<float> weight;
  std::vector<float> z;
  std::vector<float> depth;
  std::vector<float> variance;
  std::vector<float> opacity;
};

constexpr size_t kSampleCounts[] = {1, 2, 7, 15, 16, 17, 33, 64};

// From next to nothing to more than anything, the clamped range on both sides.
constexpr float kDensityRanges[][2] = {
    {-20, -9}, {-3, 0}, {0, 4}, {-5, 8}, {6, 20}, {-20, 20}};

TEST_P(CompositingTest, Forward) {
  for (const size_t n : kSampleCounts) {
    for (const auto& range : kDensityRanges) {
      Rays rays(5, n, range[0], range[1], n);
      rays.Forward();
      for (size_t ray = 0; ray < rays.num_rays; ++ray) {
        const ScalarRay expected = rays.Expected(ray);
        double sum = 0;
        for (size_t i = 0; i < n; ++i) {
          const size_t s = ray * n + i;
          ASSERT_NEAR(rays.weight[s], expected.weight[i], 2e-6);
          ASSERT_NEAR(rays.transmittance[s], expected.transmittance[i], 2e-6);
          ASSERT_NEAR(rays.z[s], expected.z[i], 3e-7);
          ASSERT_GE(rays.weight[s], 0);
          sum += rays.weight[s];
        }
        ASSERT_NEAR(sum, 1, 2e-6);
        ASSERT_NEAR(rays.depth[ray], expected.depth, 3e-6);
        ASSERT_NEAR(rays.variance[ray], expected.variance, 3e-6);
        ASSERT_NEAR(rays.opacity[ray], expected.opacity, 2e-6);
      }
    }
  }
}

// A weight's error must be small against the weight itself, or thin fog
// becomes invisible: 1 - exp(-tau) would lose it.
TEST_P(CompositingTest, ThinFogKeepsItsDigits) {
  Rays rays(3, 17, -12, -8, 1);
  rays.Forward();
  for (size_t ray = 0; ray < rays.num_rays; ++ray) {
    const ScalarRay expected = rays.Expected(ray);
    for (size_t i = 0; i + 1 < rays.n; ++i) {
      EXPECT_NEAR(rays.weight[ray * rays.n + i],
                  expected.weight[i],
                  1e-5 * expected.weight[i]);
    }
  }
}

// Both sides of the switch between the series and the closed form.
TEST_P(CompositingTest, DepthWithinAnInterval) {
  for (float log_tau = -16; log_tau < 12; log_tau += 0.01f) {
    Rays rays(1, 2, 0, 1, 1);
    rays.edges = {0.0f, 1.0f, 2.0f};
    rays.ray_length = {1.0f};
    // Beyond the clamped range, the length takes over.
    const float raw = std::max(log_tau, -11.0f);
    rays.raw_density[0] = raw;
    rays.edges[1] = std::exp(log_tau - raw);
    rays.Forward();
    const double tau = rays.tau[0];
    ASSERT_NEAR(rays.z[0] / rays.edges[1], WithinInterval(tau), 2e-6) << tau;
  }
}

// Random derivatives of everything that is rendered.
struct Gradients {
  explicit Gradients(const Rays& rays)
      : d_depth(RandomValues(rays.num_rays, -1, 1, 11)),
        d_opacity(RandomValues(rays.num_rays, -1, 1, 12)),
        pull(RandomValues(rays.num_rays, 0, 1, 13)),
        pull_z(RandomValues(rays.num_rays, 0.2f, 1.0f, 14)),
        d_weight(RandomValues(rays.num_rays * rays.n, -1, 1, 15)) {
    for (size_t ray = 0; ray < rays.num_rays; ray += 2) {
      pull[ray] = 0;
      pull_z[ray] = 0;  // must not matter
    }
  }

  // What these are the derivatives of.
  double Loss(const size_t ray, const ScalarRay& rendered) const {
    double loss =
        d_depth[ray] * rendered.depth + d_opacity[ray] * rendered.opacity;
    const size_t n = rendered.weight.size();
    for (size_t i = 0; i < n; ++i) {
      loss += d_weight[ray * n + i] * rendered.weight[i];
      if (pull[ray] != 0) {
        const double offset = rendered.z[i] / pull_z[ray] - 1;
        loss += pull[ray] * rendered.weight[i] * offset * offset;
      }
    }
    return loss;
  }

  CompositeGradients Get(const Rays& rays) const {
    CompositeGradients gradients;
    gradients.depth = rays.depth.data();
    gradients.d_depth = d_depth.data();
    gradients.d_opacity = d_opacity.data();
    gradients.pull = pull.data();
    gradients.pull_z = pull_z.data();
    gradients.d_weight_color = d_weight.data();
    return gradients;
  }

  std::vector<float> d_depth;
  std::vector<float> d_opacity;
  std::vector<float> pull;
  std::vector<float> pull_z;
  std::vector<float> d_weight;
};

TEST_P(CompositingTest, Backward) {
  for (const size_t n : kSampleCounts) {
    for (const auto& range : kDensityRanges) {
      Rays rays(4, n, range[0], range[1], 100 + n);
      rays.Forward();
      const Gradients gradients(rays);
      std::vector<float> d_raw_density(rays.num_rays * n);
      CompositeBackward(rays.Inputs(),
                        rays.Samples(),
                        gradients.Get(rays),
                        d_raw_density.data());
      for (size_t ray = 0; ray < rays.num_rays; ++ray) {
        const auto loss = [&](const std::vector<double>& raw_density) {
          return gradients.Loss(
              ray,
              ScalarRay(raw_density, rays.Edges(ray), rays.ray_length[ray]));
        };
        const std::vector<double> expected =
            NumericGradient(loss, rays.RawDensity(ray), 1e-6);
        for (size_t i = 0; i < n; ++i) {
          ASSERT_NEAR(d_raw_density[ray * n + i], expected[i], 5e-6)
              << "n " << n << " density " << range[0] << " to " << range[1];
        }
      }
    }
  }
}

// The slope of the depth within an interval shows up alone where all light ends
// in the interval whatever its density.
TEST_P(CompositingTest, SlopeWithinAnInterval) {
  for (float log_tau = -11; log_tau < 12; log_tau += 0.01f) {
    Rays rays(1, 2, 0, 1, 1);
    rays.edges = {0.0f, 1.0f, 2.0f};
    rays.ray_length = {1.0f};
    rays.raw_density[0] = log_tau;
    rays.Forward();
    Gradients gradients(rays);
    gradients.d_depth = {1};
    gradients.d_opacity = {0};
    gradients.d_weight = {0, 0};
    float d_raw_density[2];
    CompositeBackward(
        rays.Inputs(), rays.Samples(), gradients.Get(rays), d_raw_density);
    const double tau = std::exp(static_cast<double>(log_tau));
    // depth = w f(tau) + (1 - w) 1.5 with w = 1 - exp(-tau).
    const double w = -std::expm1(-tau);
    const double expected =
        tau * (std::exp(-tau) * (WithinInterval(tau) - 1.5) +
               w * WithinIntervalDerivative(tau));
    ASSERT_NEAR(d_raw_density[0], expected, 2e-6 + 2e-5 * std::abs(expected))
        << log_tau;
    ASSERT_EQ(d_raw_density[1], 0);
  }
}

TEST_P(CompositingTest, ClampedDensityHasNoGradient) {
  Rays rays(1, 4, 0, 0, 1);
  const float raw_density[] = {-12.5f, 12.5f, 100.0f, 0.0f};
  for (int i = 0; i < 4; ++i) {
    rays.raw_density[i * kStride] = raw_density[i];
  }
  rays.edges = {0.1f, 0.2f, 0.2f, 0.3f, 0.4f};
  rays.Forward();
  const Gradients gradients(rays);
  std::vector<float> d_raw_density(4, 7.0f);
  CompositeBackward(
      rays.Inputs(), rays.Samples(), gradients.Get(rays), d_raw_density.data());
  for (const float d : d_raw_density) {
    EXPECT_EQ(d, 0);
  }
}

TEST_P(CompositingTest, IntervalsWithoutLength) {
  Rays rays(1, 5, 3, 3.1f, 1);
  rays.edges.assign(6, 0.5f);
  rays.Forward();
  EXPECT_EQ(rays.depth[0], 0.5f);
  EXPECT_EQ(rays.variance[0], 0.0f);
  EXPECT_EQ(rays.opacity[0], 0.0f);
  EXPECT_EQ(rays.weight[4], 1.0f);
  const Gradients gradients(rays);
  std::vector<float> d_raw_density(5, 7.0f);
  CompositeBackward(
      rays.Inputs(), rays.Samples(), gradients.Get(rays), d_raw_density.data());
  for (const float d : d_raw_density) {
    EXPECT_EQ(d, 0);
  }
}

TEST_P(CompositingTest, NoRays) {
  Rays rays(0, 16, 0, 1, 1);
  rays.Forward();
  const Gradients gradients(rays);
  CompositeBackward(
      rays.Inputs(), rays.Samples(), gradients.Get(rays), nullptr);
}

// An opaque surface lies where its first interval begins.
TEST_P(CompositingTest, OpaqueSurface) {
  Rays rays(1, 16, -20, -20, 1);
  for (size_t i = 0; i <= rays.n; ++i) {
    rays.edges[i] = 0.1f + 0.05f * static_cast<float>(i);
  }
  rays.raw_density[9 * kStride] = kMaxRawDensity;
  rays.Forward();
  EXPECT_NEAR(rays.depth[0], rays.edges[9], 2e-4);
  EXPECT_NEAR(rays.variance[0], 0, 1e-6);
  EXPECT_EQ(rays.opacity[0], 1.0f);
}

STRUCTNERF_FOR_EACH_SIMD_TARGET(CompositingTest);

}  // namespace
}  // namespace structnerf
