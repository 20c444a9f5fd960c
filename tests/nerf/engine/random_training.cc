#include "tests/nerf/engine/random_training.h"

#include <gtest/gtest.h>

namespace structnerf {

EngineOptions MakeOptions(const int num_threads) {
  EngineOptions options;
  options.field.log2_table_size = 11;
  options.field.max_resolution = 64;
  options.sampling.num_bins = 32;
  options.sampling.cache_resolution = 32;
  options.extent = Eigen::Vector3f(1.0f, 0.7f, 0.9f);
  options.num_threads = num_threads;
  options.seed = 5;
  return options;
}

StepParameters MakeStep(const int step) {
  StepParameters parameters;
  parameters.step = step;
  parameters.num_tiles = 13;
  return parameters;
}

std::vector<double> Train(const int first_step,
                          const int num_steps,
                          RenderEngine* engine) {
  const auto objectives = RandomObjectives(*engine, 3, kTileRays);
  std::vector<double> losses;
  for (int step = first_step; step < first_step + num_steps; ++step) {
    for (const double loss : engine->Accumulate(MakeStep(step), objectives)) {
      losses.push_back(loss);
    }
    EXPECT_TRUE(engine->Update(1e-2f, 5e-3f));
    if (step % 3 == 2) {
      engine->RefreshDensityCache(0.9f);
    }
  }
  return losses;
}

void ExpectSameRendering(const std::vector<RayTile>& tiles,
                         GridEngine* engine,
                         GridEngine* other) {
  const FieldParameters parameters =
      RandomParameters(engine->Layout(), 1.0f, 5.0f, 1);
  std::vector<RayOutputs> actual;
  std::vector<RayOutputs> expected;
  engine->SetParameters(parameters);
  engine->Render(tiles, /*with_color=*/true, &actual);
  other->SetParameters(parameters);
  other->Render(tiles, /*with_color=*/true, &expected);
  ASSERT_EQ(actual.size(), tiles.size());
  for (size_t tile = 0; tile < tiles.size(); ++tile) {
    for (int ray = 0; ray < tiles[tile].num_rays; ++ray) {
      const RayOutputs& a = actual[tile];
      const RayOutputs& e = expected[tile];
      for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(a.color[c][ray], e.color[c][ray], 2e-3);
      }
      EXPECT_NEAR(a.depth[ray], e.depth[ray], 1e-5);
      EXPECT_NEAR(a.depth_variance[ray], e.depth_variance[ray], 1e-5);
      EXPECT_NEAR(a.opacity[ray], e.opacity[ray], 1e-5);
    }
  }
}

}  // namespace structnerf
