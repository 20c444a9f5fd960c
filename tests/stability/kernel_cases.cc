// Every kernel, on every instruction set of this machine, with numbers at the
// ends of what floats hold.

#include "nerf/engine/grid_engine.h"
#include "nerf/field/density_cache.h"
#include "nerf/kernels/adam.h"
#include "nerf/kernels/color_compositing.h"
#include "nerf/kernels/dense_layer.h"
#include "nerf/kernels/grid_encoding.h"
#include "nerf/kernels/half_precision.h"
#include "nerf/kernels/ray_sampling.h"
#include "nerf/train/training_guards.h"
#include "tests/nerf/engine/random_scene.h"
#include "tests/stability/double_compositing.h"
#include "tests/stability/simd_extremes.h"
#include "tests/stability/stability_case.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include <hwy/base.h>

namespace structnerf {
namespace {

// Rays of 16 intervals with the given densities (raw) and interval lengths, to
// be picked from.
CompositeRays MakeRays(const std::vector<float>& densities,
                       const std::vector<float>& lengths) {
  CompositeRays rays(/*num_rays=*/64, /*num_samples=*/16);
  rays.raw_density = PickMany(densities, rays.raw_density.size(), 1);
  rays.ray_length = PickMany({1.0f, 1.7f}, rays.num_rays, 2);
  const std::vector<float> steps =
      PickMany(lengths, rays.num_rays * rays.num_samples, 3);
  for (size_t ray = 0; ray < rays.num_rays; ++ray) {
    float edge = 0.01f;
    for (size_t i = 0; i <= rays.num_samples; ++i) {
      rays.edges[ray * (rays.num_samples + 1) + i] = edge;
      edge += i < rays.num_samples ? steps[ray * rays.num_samples + i] : 0.0f;
    }
  }
  return rays;
}

std::string MeasureCompositing(const std::vector<float>& densities,
                               const std::vector<float>& lengths) {
  const CompositeRays rays = MakeRays(densities, lengths);
  const double worst_weight = WorstOfTargets([&] {
    const CompositeResult result = Composite(rays);
    double worst = 0;
    for (size_t ray = 0; ray < rays.num_rays; ++ray) {
      const DoubleRay expected = CompositeInDouble(rays, ray);
      double sum = 0;
      for (size_t i = 0; i < rays.num_samples; ++i) {
        const float weight = result.weight[ray * rays.num_samples + i];
        worst = std::max(worst, std::abs(weight - expected.weight[i]));
        sum += weight;
      }
      const double far = rays.edges[(ray + 1) * (rays.num_samples + 1) - 1];
      worst = std::max(worst, std::abs(sum - 1));
      worst =
          std::max(worst, std::abs(result.depth[ray] - expected.depth) / far);
    }
    RequireFinite(result.depth, "a depth");
    RequireFinite(result.depth_variance, "a variance");
    RequireFinite(result.opacity, "an opacity");
    return worst;
  });
  const double largest_gradient = WorstOfTargets([&] {
    double largest = 0;
    for (const float gradient : {0.0f, 1e-30f, -1.0f, 1e6f}) {
      const std::vector<float> d_raw =
          CompositeGradient(rays,
                            Composite(rays),
                            gradient,
                            /*pull=*/std::abs(gradient),
                            /*pull_z=*/0.5f);
      RequireFinite(d_raw, "a gradient");
      for (const float value : d_raw) {
        largest = std::max(largest, static_cast<double>(std::abs(value)));
      }
    }
    return largest;
  });
  RequireStable(worst_weight < 1e-5,
                "weights or depths are off by " + ShortNumber(worst_weight));
  return "weights, their sum and depths within " + ShortNumber(worst_weight) +
         " of double; gradients up to " + ShortNumber(largest_gradient);
}

std::string MeasureColorCompositing() {
  const double worst = WorstOfTargets([] {
    constexpr size_t kRays = 8;
    constexpr size_t kSamples = 32;  // per ray
    const auto weight =
        PickMany({1e-38f, 1e-20f, 1e-4f, 0.5f, 1.0f}, kRays * kSamples, 1);
    auto color = PickMany(
        {0.0f, 1e-30f, 0.5f, 1.0f}, kRays * kSamples * kColorOutputWidth, 2);
    std::vector<uint32_t> samples(kRays * kSamples);
    std::vector<uint32_t> rays(kRays * kSamples);
    for (uint32_t s = 0; s < samples.size(); ++s) {
      samples[s] = s;
      rays[s] = s / kSamples;
      color[s * kColorOutputWidth + 3] = 0;
    }
    const ActiveColors active = {samples.size(),
                                 samples.data(),
                                 rays.data(),
                                 color.data(),
                                 weight.data()};
    std::vector<float> ray_color(kRays * kRayColorWidth);
    CompositeColor(active, kRays, ray_color.data());
    double error = 0;
    for (size_t ray = 0; ray < kRays; ++ray) {
      double sum = 0;
      double sum_weights = 0;
      for (size_t s = ray * kSamples; s < (ray + 1) * kSamples; ++s) {
        sum += static_cast<double>(weight[s]) * color[s * kColorOutputWidth];
        sum_weights += weight[s];
      }
      error = std::max(
          error, std::abs(ray_color[ray * kRayColorWidth] - sum / sum_weights));
    }
    auto d_ray_color =
        PickMany({-1e6f, 1e-30f, 0.0f, 1.0f}, kRays * kRayColorWidth, 3);
    for (size_t ray = 0; ray < kRays; ++ray) {
      d_ray_color[ray * kRayColorWidth + 3] = 0;
    }
    std::vector<float> d_weight(samples.size());
    std::vector<float> d_color(color.size());
    CompositeColorBackward(active,
                           ray_color.data(),
                           d_ray_color.data(),
                           d_weight.data(),
                           d_color.data());
    RequireFinite(d_weight, "a gradient by weight");
    RequireFinite(d_color, "a gradient by colour");
    return error;
  });
  RequireStable(worst < 1e-5, "colours are off by " + ShortNumber(worst));
  return "colours within " + ShortNumber(worst) + " of double";
}

// Three layers with weights and inputs as large as guards let them get.
std::string MeasureDenseLayers() {
  double largest = 0;
  const double worst = WorstOfTargets([&] {
    constexpr size_t kRows = 9;
    constexpr size_t kWidth = 32;
    constexpr float kMax = TrainingGuards::kMaxParameter;
    auto x = PickMany({-kMax, 1e-40f, 0.0f, 1.0f, kMax}, kRows * kWidth, 1);
    const auto w = PickMany({-kMax, 1e-40f, 1.0f, kMax}, kWidth * kWidth, 2);
    const auto b = PickMany({-kMax, 0.0f, kMax}, kWidth, 3);
    double error = 0;
    for (int layer = 0; layer < 3; ++layer) {
      std::vector<float> y(kRows * kWidth);
      DenseForward(x.data(),
                   w.data(),
                   b.data(),
                   nullptr,
                   kRows,
                   kWidth,
                   kWidth,
                   /*rectify=*/true,
                   y.data());
      RequireFinite(y, "an activation");
      for (size_t row = 0; row < kRows; ++row) {
        for (size_t col = 0; col < kWidth; ++col) {
          double sum = b[col];
          double magnitude = std::abs(b[col]);
          for (size_t k = 0; k < kWidth; ++k) {
            const double term =
                static_cast<double>(x[row * kWidth + k]) * w[k * kWidth + col];
            sum += term;
            magnitude += std::abs(term);
          }
          const double difference =
              std::abs(y[row * kWidth + col] - std::max(sum, 0.0));
          error = std::max(error, difference / std::max(magnitude, 1e-30));
          largest = std::max(
              largest, static_cast<double>(std::abs(y[row * kWidth + col])));
        }
      }
      x = y;
    }
    auto extremes = PickMany({-kInfinity,
                              -kLargest,
                              -100.0f,
                              -1e-40f,
                              0.0f,
                              1e-40f,
                              100.0f,
                              kLargest,
                              kInfinity},
                             16 * 4,
                             4);
    const auto inputs = extremes;
    Sigmoid(extremes.size(), extremes.data());
    for (size_t i = 0; i < extremes.size(); ++i) {
      error = std::max(
          error, std::abs(extremes[i] - 1 / (1 + std::exp(-1.0 * inputs[i]))));
    }
    return error;
  });
  RequireStable(worst < 1e-5, "results are off by " + ShortNumber(worst));
  return "within " + ShortNumber(worst) +
         " of double, relative to their terms; activations up to " +
         ShortNumber(largest);
}

std::string MeasureGridEncoding() {
  const double worst = WorstOfTargets([] {
    const FieldLayout layout = ExtremeLayout();
    constexpr size_t kSamples = 64;
    const auto x = ExtremePlaces(kSamples + 16, 1);
    const auto y = ExtremePlaces(kSamples + 16, 2);
    const auto z = ExtremePlaces(kSamples + 16, 3);
    double error = 0;
    for (const GridLevel& level : layout.levels) {
      std::vector<uint32_t> entries(8 * kSamples);
      std::vector<float> weights(8 * kSamples);
      GridCorners(level,
                  x.data(),
                  y.data(),
                  z.data(),
                  kSamples,
                  kSamples,
                  entries.data(),
                  weights.data());
      for (const uint32_t entry : entries) {
        RequireStable(entry < level.num_entries, "an entry does not exist");
      }
      for (size_t s = 0; s < kSamples; ++s) {
        double sum = 0;
        for (int corner = 0; corner < 8; ++corner) {
          sum += weights[corner * kSamples + s];
        }
        error = std::max(error, std::abs(sum - 1));
      }
      const auto features = PickMany(
          {-TrainingGuards::kMaxParameter, TrainingGuards::kMaxParameter},
          level.num_entries * kGridFeatures,
          4);
      std::vector<hwy::float16_t> table(features.size());
      HalfFromFloat(features.data(), features.size(), table.data());
      std::vector<float> encoding(kSamples * kGridFeatures);
      GridInterpolate(table.data(),
                      entries.data(),
                      weights.data(),
                      kSamples,
                      kSamples,
                      1.0f,
                      kGridFeatures,
                      encoding.data());
      RequireFinite(encoding, "a feature");
    }
    return error;
  });
  RequireStable(worst < 1e-5,
                "weights sum to one within " + ShortNumber(worst));
  return "entries exist, weights sum to one within " + ShortNumber(worst) +
         ", also for places at infinity and none";
}

std::string MeasureHalfPrecision() {
  const double worst = WorstOfTargets([] {
    std::vector<float> values = {0.0f, -0.0f, 1e-40f, 1e-20f};
    for (float value = 6.2e-5f; value < TrainingGuards::kMaxParameter;
         value *= 1.37f) {
      values.push_back(value);
      values.push_back(-value);
    }
    values.push_back(TrainingGuards::kMaxParameter);
    std::vector<hwy::float16_t> halves(values.size());
    std::vector<float> back(values.size());
    HalfFromFloat(values.data(), values.size(), halves.data());
    FloatFromHalf(halves.data(), halves.size(), back.data());
    double error = 0;
    for (size_t i = 0; i < values.size(); ++i) {
      error = std::max<double>(error,
                               std::abs(back[i] - values[i]) /
                                   std::max(std::abs(values[i]), 6.2e-5f));
    }
    return error;
  });
  // Rounded to nearest, or towards zero where there is no instruction for it.
  RequireStable(worst <= 1.0 / 1024, "off by " + ShortNumber(worst));
  return "within " + ShortNumber(worst) + ", relative, up to 65504";
}

std::string MeasureAdam() {
  double largest_change = 0;
  WorstOfTargets([&] {
    for (const float rate : {1e-30f, 1e-2f, 1e3f}) {
      for (const std::vector<float>& choices :
           {std::vector<float>{1e-45f, -1e-38f, 1e-30f},
            std::vector<float>{9.9e17f, -9.9e17f},
            std::vector<float>{1e-38f, 9.9e17f, -1.0f}}) {
        AdamStep step;
        step.learning_rate = rate;
        constexpr size_t kCount = 16;
        std::vector<float> m(kCount);
        std::vector<float> root_v(kCount);
        std::vector<float> values(kCount);
        std::vector<GridEntryState> state(2);
        std::vector<hwy::float16_t> table(kCount);
        const std::vector<uint16_t> entries = {0, 1};
        for (int k = 0; k < 300; ++k) {
          auto gradient = PickMany(choices, kCount, k);
          AdamUpdate(step,
                     kCount,
                     gradient.data(),
                     m.data(),
                     root_v.data(),
                     values.data());
          RequireStable(AdamUpdateGrid(step,
                                       entries.data(),
                                       2,
                                       gradient.data(),
                                       state.data(),
                                       table.data()),
                        "a gradient was refused");
        }
        RequireFinite(m, "a moment");
        RequireFinite(root_v, "a moment");
        RequireFinite(values, "a parameter");
        for (const GridEntryState& entry : state) {
          for (const float value : entry.value) {
            RequireStable(std::isfinite(value), "a feature is infinite");
            largest_change =
                std::max(largest_change, std::abs(value) / 300.0 / rate);
          }
        }
      }
    }
    return 0.0;
  });
  RequireStable(largest_change < 10, "steps of " + ShortNumber(largest_change));
  return "300 steps with gradients of 1e-45 to 9.9e17: moments finite, mean "
         "step " +
         ShortNumber(largest_change) + " learning rates at most";
}

std::string MeasureRaySampling() {
  const double worst = WorstOfTargets([] {
    double error = 0;
    for (const float density : {1e-30f, 1.0f, 1e30f}) {
      const DensityCache cache(16, Eigen::Vector3f(1, 0.5f, 1), density);
      for (const float near : {1e-30f, 1e-7f, 0.1f}) {
        for (const float ratio : {2.0f, 1e6f, 1e30f}) {
          RayTile rays = RandomRays(3, 0, 0, 21);
          rays.near.fill(near);
          rays.far.fill(near * ratio);
          for (const int num_samples : {1, 2, 64}) {
            RaySamplingParameters parameters;
            parameters.num_samples = num_samples;
            PerRay<float> jitter;
            jitter.fill(0.999999f);
            std::vector<float> edges(kMaxTileRays * (num_samples + 1));
            ChooseIntervals(rays, cache, parameters, jitter, edges.data());
            RequireFinite(edges, "an edge");
            for (int ray = 0; ray < rays.num_rays; ++ray) {
              const float* const e = edges.data() + ray * (num_samples + 1);
              RequireStable(std::is_sorted(e, e + num_samples + 1),
                            "edges are not ascending");
              error = std::max<double>(error, std::abs(e[0] / near - 1));
              error = std::max<double>(
                  error, std::abs(e[num_samples] / (near * ratio) - 1));
            }
          }
        }
      }
    }
    return error;
  });
  RequireStable(worst < 1e-6, "rays end " + ShortNumber(worst) + " off");
  return "edges ascend from near to far, ratios of 2 to 1e30, densities of "
         "1e-30 to 1e30";
}

std::string MeasureDensityCache() {
  DensityCache cache(16, Eigen::Vector3f(1, 0.5f, 1), 1.0f);
  const std::vector<float> numbers = {
      -kInfinity, -kLargest, 0, 0.3f, kLargest, kInfinity, kNan};
  constexpr size_t kCount = 500;
  const auto x = PickMany(numbers, kCount, 1);
  const auto y = PickMany(numbers, kCount, 2);
  const auto z = PickMany(numbers, kCount, 3);
  const auto density = PickMany(numbers, kCount, 4);
  cache.Observe(x.data(), y.data(), z.data(), density.data(), kCount, 0.8f);
  // What was believed of a place that nothing more is said about fades.
  const std::vector<float> nothing(1, -kInfinity);
  const std::vector<float> place(1, 0.3f);
  int num_observations = 0;
  const uint8_t* const cell = cache.Data() + cache.CellIndex(4, 4, 4);
  while (*cell > 0 && num_observations < 1000) {
    cache.Observe(
        place.data(), place.data(), place.data(), nothing.data(), 1, 0.8f);
    ++num_observations;
  }
  RequireStable(*cell == 0, "a cell does not forget");
  return "takes densities and places at infinity and none; forgets in " +
         std::to_string(num_observations) + " observations";
}

// Gradients that are all the same number, whatever is rendered.
class ConstantObjective : public TileObjective {
 public:
  explicit ConstantObjective(const float gradient) : gradient_(gradient) {}

  void DrawRays(const int step, const int tile, RayTile* rays) override {
    *rays = RandomRays(5, step, tile, kMaxTileRays);
  }

  LossValues Evaluate(const RayOutputs&, RayGradients* gradients) override {
    gradients->d_depth.fill(gradient_);
    for (int c = 0; c < 3; ++c) {
      gradients->d_color[c].fill(gradient_);
    }
    return {};
  }

 private:
  const float gradient_;
};

// All kernels of a step, one after the other.
std::string MeasureStep(const float gradient, const bool is_update_expected) {
  double largest = 0;
  WorstOfTargets([&] {
    EngineOptions options;
    options.field.log2_table_size = 10;
    options.sampling.cache_resolution = 16;
    options.num_threads = 2;
    const auto engine = MakeFusedEngine(options);
    std::vector<std::unique_ptr<TileObjective>> objectives;
    for (int i = 0; i < engine->NumThreads(); ++i) {
      objectives.push_back(std::make_unique<ConstantObjective>(gradient));
    }
    StepParameters step;
    step.num_tiles = 4;
    for (; step.step < 5; ++step.step) {
      engine->Accumulate(step, objectives);
      RequireStable(engine->Update(1e-2f, 1e-2f) == is_update_expected,
                    "the update was not " +
                        std::string(is_update_expected ? "taken" : "skipped"));
      engine->RefreshDensityCache(0.8f);
    }
    const FieldParameters parameters = engine->MasterParameters();
    RequireFinite(parameters.grid, "a feature");
    RequireFinite(parameters.network, "a parameter");
    for (const float value : parameters.network) {
      largest = std::max(largest, static_cast<double>(std::abs(value)));
    }
    return 0.0;
  });
  return std::string(is_update_expected ? "updated" : "skipped") +
         "; parameters finite, up to " + ShortNumber(largest);
}

}  // namespace

std::vector<StabilityCase> KernelCases() {
  const std::vector<float> all_densities = {-kInfinity,
                                            -kLargest,
                                            -1e4f,
                                            -12,
                                            -5,
                                            0,
                                            5,
                                            12,
                                            1e4f,
                                            kLargest,
                                            kInfinity};
  const std::vector<float> lengths = {0, 1e-30f, 1e-6f, 1e-2f, 0.3f};
  std::vector<StabilityCase> cases = {
      {"compositing: densities of any size",
       [=] { return MeasureCompositing(all_densities, lengths); }},
      {"compositing: all opaque",
       [=] { return MeasureCompositing({kLargest}, {0.3f}); }},
      {"compositing: all transparent",
       [=] { return MeasureCompositing({-kLargest}, lengths); }},
      {"compositing: rays of length 0",
       [=] { return MeasureCompositing(all_densities, {0}); }},
      {"compositing: rays of length 1e6",
       [=] {
         return MeasureCompositing(all_densities, {1, 1e6f});
       }},
      {"colour compositing: weights of 1e-38 to 1", MeasureColorCompositing},
      {"dense layers: weights of 1e-40 to 65504", MeasureDenseLayers},
      {"grid encoding: places anywhere", MeasureGridEncoding},
      {"half precision: its whole range", MeasureHalfPrecision},
      {"Adam: gradients of any size", MeasureAdam},
      {"ray sampling: any range and density", MeasureRaySampling},
      {"density cache: any place and density", MeasureDensityCache}};
  for (const float gradient : {0.0f, 1e-42f, 1e-20f, 1e10f}) {
    cases.push_back({"a step with gradients of " + ShortNumber(gradient),
                     [=] { return MeasureStep(gradient, true); }});
  }
  for (const float gradient : {1e25f, kInfinity, kNan}) {
    cases.push_back({"a step with gradients of " + ShortNumber(gradient),
                     [=] { return MeasureStep(gradient, false); }});
  }
  return cases;
}

}  // namespace structnerf
