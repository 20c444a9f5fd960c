// Gradients of the fused engine against those of the same engine in
// double-precision tensor operations.

#include "nerf/engine/grid_engine.h"
#include "nerf/engine/torch_engine.h"
#include "tests/nerf/engine/random_scene.h"
#include "tests/nerf/simd_targets.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <vector>

namespace structnerf {
namespace {

constexpr int kNumTiles = 8;
constexpr int kTileRays = 5;
constexpr double kTolerance = 1e-4;

struct Case {
  int num_samples = 16;
  int hidden_width = 32;
  int num_levels = 4;
  int log2_table_size = 9;
  int direction_degree = 2;
  float grid_range = 1.0f;
  float initial_density = 5.0f;
  std::vector<float> level_weights;
  bool with_empty_rays = false;
  uint64_t seed = 0;
};

// Of whose rays every third ends where it begins, so that all of its intervals
// have length zero.
class EmptyRaysObjective : public RandomObjective {
 public:
  using RandomObjective::RandomObjective;

  void DrawRays(const int step, const int tile, RayTile* rays) override {
    RandomObjective::DrawRays(step, tile, rays);
    for (int ray = 0; ray < rays->num_rays; ray += 3) {
      rays->far[ray] = rays->near[ray];
    }
  }
};

double Norm(const std::vector<float>& values,
            const size_t begin,
            const size_t end) {
  double sum = 0;
  for (size_t i = begin; i < end; ++i) {
    sum += static_cast<double>(values[i]) * values[i];
  }
  return std::sqrt(sum);
}

EngineOptions MakeOptions(const Case& test_case) {
  EngineOptions options;
  options.field.num_levels = test_case.num_levels;
  options.field.log2_table_size = test_case.log2_table_size;
  options.field.min_resolution = 4;
  options.field.max_resolution = 64;
  options.field.hidden_width = test_case.hidden_width;
  options.field.direction_degree = test_case.direction_degree;
  options.sampling.num_bins = 32;
  options.sampling.num_samples = test_case.num_samples;
  options.sampling.cache_resolution = 16;
  options.extent = Eigen::Vector3f(1.0f, 0.7f, 0.9f);
  options.min_color_weight = 0;
  options.num_threads = 1;
  options.seed = static_cast<int>(test_case.seed);
  return options;
}

struct StepResult {
  LossValues losses;
  FieldParameters gradients;
};

StepResult RunStep(const Case& test_case,
                   const FieldParameters& parameters,
                   RenderEngine* engine) {
  StepParameters step;
  step.step = 3;
  step.num_tiles = kNumTiles;
  step.level_weights = test_case.level_weights;
  engine->SetParameters(parameters);
  std::vector<std::unique_ptr<TileObjective>> objectives =
      RandomObjectives(*engine, test_case.seed, kTileRays);
  if (test_case.with_empty_rays) {
    for (std::unique_ptr<TileObjective>& objective : objectives) {
      objective =
          std::make_unique<EmptyRaysObjective>(test_case.seed, kTileRays);
    }
  }
  StepResult result;
  result.losses = engine->Accumulate(step, objectives);
  result.gradients = engine->Gradients();
  return result;
}

// Largest relative error of the gradient over the parts of the field (every
// grid level, every layer's weights and biases), each measured norm-wise. Parts
// that get next to nothing are measured against the whole.
double GradientError(const FieldLayout& layout,
                     const FieldParameters& actual,
                     const FieldParameters& expected) {
  double largest = 0;
  const auto measure = [&](const std::vector<float>& a,
                           const std::vector<float>& e,
                           const size_t begin,
                           const size_t end) {
    std::vector<float> difference(end - begin);
    for (size_t i = begin; i < end; ++i) {
      difference[i - begin] = a[i] - e[i];
    }
    const double scale =
        std::max(Norm(e, begin, end), 0.01 * Norm(e, 0, e.size()));
    const double error = Norm(difference, 0, difference.size());
    largest = std::max(largest, scale > 0 ? error / scale : error);
  };
  for (const GridLevel& level : layout.levels) {
    const size_t begin = level.first_entry * kGridFeatures;
    measure(actual.grid,
            expected.grid,
            begin,
            begin + level.num_entries * kGridFeatures);
  }
  for (const LayerLayout* layer : {&layout.density_hidden,
                                   &layout.density_output,
                                   &layout.color_hidden,
                                   &layout.color_output}) {
    measure(actual.network, expected.network, layer->weights, layer->biases);
    measure(actual.network,
            expected.network,
            layer->biases,
            layer->biases + layer->num_outputs);
  }
  return largest;
}

void ShiftHiddenBiases(const FieldLayout& layout,
                       const float shift,
                       FieldParameters* parameters) {
  for (const LayerLayout* layer :
       {&layout.density_hidden, &layout.color_hidden}) {
    for (int i = 0; i < layer->num_outputs; ++i) {
      parameters->network[layer->biases + i] += shift;
    }
  }
}

// Accumulates a step in both engines and compares.
void ExpectSameGradients(const Case& test_case) {
  const EngineOptions options = MakeOptions(test_case);
  const auto fused = MakeFusedEngine(options);
  const FieldLayout& layout = fused->Layout();
  const FieldParameters parameters = RandomParameters(
      layout, test_case.grid_range, test_case.initial_density, test_case.seed);
  const StepResult actual = RunStep(test_case, parameters, fused.get());

  // A rectifier's derivative jumps at zero, where float and double may stand on
  // different sides. If so, the oracle is asked a few roundings to either side.
  double error = std::numeric_limits<double>::infinity();
  for (const float shift : {0.0f, 3e-7f, -3e-7f}) {
    FieldParameters shifted = parameters;
    ShiftHiddenBiases(layout, shift, &shifted);
    const auto oracle = MakeTorchEngine(options, TorchPrecision::kDouble);
    const StepResult expected = RunStep(test_case, shifted, oracle.get());
    error = std::min(
        error, GradientError(layout, actual.gradients, expected.gradients));
    for (size_t term = 0; term < expected.losses.size(); ++term) {
      EXPECT_NEAR(actual.losses[term],
                  expected.losses[term],
                  1e-5 * (1 + std::abs(expected.losses[term])))
          << "term " << term;
    }
    if (error < kTolerance) {
      break;
    }
  }
  EXPECT_LT(error, kTolerance);
}

class GradientsTest : public SimdTargetTest {};

TEST_P(GradientsTest, SampleCounts) {
  Case test_case;
  for (const int num_samples : {1, 2, 7, 16, 33, 64}) {
    SCOPED_TRACE(num_samples);
    test_case.num_samples = num_samples;
    ++test_case.seed;
    ExpectSameGradients(test_case);
  }
}

TEST_P(GradientsTest, HiddenWidths) {
  Case test_case;
  for (const int hidden_width : {16, 32, 48, 64}) {
    SCOPED_TRACE(hidden_width);
    test_case.hidden_width = hidden_width;
    ++test_case.seed;
    ExpectSameGradients(test_case);
  }
}

TEST_P(GradientsTest, LevelCounts) {
  Case test_case;
  for (const int num_levels : {1, 2, 3, 4, 5, 6, 7, 8, 11, 16}) {
    SCOPED_TRACE(num_levels);
    test_case.num_levels = num_levels;
    ++test_case.seed;
    ExpectSameGradients(test_case);
  }
}

TEST_P(GradientsTest, DirectionDegrees) {
  Case test_case;
  for (const int degree : {0, 1}) {
    SCOPED_TRACE(degree);
    test_case.direction_degree = degree;
    ++test_case.seed;
    ExpectSameGradients(test_case);
  }
}

TEST_P(GradientsTest, RaysWithoutLength) {
  Case test_case;
  test_case.with_empty_rays = true;
  for (const int num_samples : {1, 16}) {
    SCOPED_TRACE(num_samples);
    test_case.num_samples = num_samples;
    ++test_case.seed;
    ExpectSameGradients(test_case);
  }
}

TEST_P(GradientsTest, Seeds) {
  Random random(7);
  for (uint64_t seed = 0; seed < 12; ++seed) {
    SCOPED_TRACE(seed);
    Case test_case;
    test_case.seed = 100 + seed;
    test_case.num_samples = 1 + random.NextBelow(64);
    test_case.hidden_width = 16 * (1 + random.NextBelow(4));
    test_case.num_levels = 1 + random.NextBelow(16);
    test_case.log2_table_size = 6 + random.NextBelow(9);
    ExpectSameGradients(test_case);
  }
}

TEST_P(GradientsTest, NearlyEmptyAndNearlyOpaqueFields) {
  Case test_case;
  for (const float density : {1e-4f, 1e-2f, 30.0f, 300.0f, 3000.0f}) {
    SCOPED_TRACE(density);
    test_case.initial_density = density;
    ++test_case.seed;
    ExpectSameGradients(test_case);
  }
}

// Raw densities on both sides of the range they are clamped to.
TEST_P(GradientsTest, SaturatedDensity) {
  Case test_case;
  for (const float grid_range : {10.0f, 100.0f}) {
    SCOPED_TRACE(grid_range);
    test_case.grid_range = grid_range;
    ++test_case.seed;
    ExpectSameGradients(test_case);
  }
}

TEST_P(GradientsTest, WithheldLevels) {
  Case test_case;
  test_case.level_weights = {1.0f, 0.5f, 0.01f, 0.0f};
  ExpectSameGradients(test_case);
}

STRUCTNERF_FOR_EACH_SIMD_TARGET(GradientsTest);

}  // namespace
}  // namespace structnerf
