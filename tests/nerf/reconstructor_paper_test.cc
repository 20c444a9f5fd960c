// The paper's preset, with a smaller network and on small images, from start to
// end.

#include "nerf/engine/torch_factory.h"
#include "nerf/reconstructor.h"
#include "tests/nerf/train/objective_scene.h"
#include "tests/support/temp_dir.h"

#include <cmath>
#include <stdexcept>
#include <string>

#include <gtest/gtest.h>

namespace structnerf {
namespace {

ReconstructionOptions ShortPaperRun() {
  ReconstructionOptions options = QualityPreset("paper");
  options.field.mlp_width = 32;
  options.field.mlp_num_layers = 4;
  options.sampling.num_samples = 16;
  options.sampling.num_fine_samples = 16;
  options.training.rays_per_step = 128;
  options.training.num_steps = 60;
  // The paper's rate is for a thousand times as many.
  options.training.network_learning_rate = 5e-3;
  return options;
}

TEST(Reconstructor, PaperPresetLearnsAndItsFieldIsKept) {
  const ReconstructionOptions options = ShortPaperRun();
  const Scene scene = ObjectiveScene().scene;
  Reconstructor reconstructor(scene, options, MakeAnyEngine);
  Progress progress;
  const DenseMaps before = reconstructor.RenderView(0, &progress);
  reconstructor.Train(&progress);
  const TrainingSummary& summary = reconstructor.Summary();
  EXPECT_EQ(summary.num_steps, 60);
  EXPECT_EQ(summary.num_samples, 60u * 128 * (2 * 16 + 16));
  EXPECT_GT(summary.held_out_psnr, 12);
  for (const auto& [guard, count] : summary.guard_counts) {
    EXPECT_EQ(count, 0) << guard;
  }

  // Nearer to the wall than at the start, in the mean.
  const DenseMaps after = reconstructor.RenderView(0, &progress);
  const ObjectiveScene truth;
  const auto mean_error = [&](const DenseMaps& maps) {
    double sum = 0;
    int count = 0;
    for (int row = 0; row < maps.height; ++row) {
      for (int col = 0; col < maps.width; ++col) {
        const float depth = maps.depth[row * maps.width + col];
        if (depth > 0) {
          const double expected = truth.plane.Depth(scene.views[0], col, row);
          sum += std::abs(std::log(depth / expected));
          ++count;
        }
      }
    }
    return sum / count;
  };
  EXPECT_LT(mean_error(after), 0.8 * mean_error(before));

  const TempDir temp_dir;
  reconstructor.SaveField(temp_dir / "field.bin");
  Reconstructor other(scene, options, MakeAnyEngine);
  other.LoadField(temp_dir / "field.bin");
  EXPECT_EQ(other.RenderView(0, &progress).depth, after.depth);
  // A grid is another shape.
  ReconstructionOptions grid_options = options;
  grid_options.field.type = "grid";
  Reconstructor grid(scene, grid_options, MakeAnyEngine);
  EXPECT_THROW(grid.LoadField(temp_dir / "field.bin"), std::runtime_error);
}

// The appendix' experiment. A photograph that was kept out is rendered with a
// code of zeros, or that of its neighbours.
TEST(Reconstructor, LatentCodesOfViewsKeptOut) {
  ReconstructionOptions options = ShortPaperRun();
  options.field.latent_size = 8;
  options.training.test_every = 3;
  // Photographs of different exposure.
  Scene scene = ObjectiveScene().scene;
  for (size_t v = 0; v < scene.views.size(); ++v) {
    for (uint8_t& value : scene.views[v].image.data) {
      value = static_cast<uint8_t>(value * (v == 0 ? 0.4 : 1.0));
    }
  }
  Progress progress;
  const auto psnr_of = [&](const std::string& latent_test) {
    options.training.latent_test = latent_test;
    Reconstructor reconstructor(scene, options, MakeAnyEngine);
    reconstructor.Train(&progress);
    const TempDir temp_dir;
    reconstructor.SaveField(temp_dir / "field.bin");
    EXPECT_NO_THROW(reconstructor.LoadField(temp_dir / "field.bin"));
    return reconstructor.Summary().held_out_psnr;
  };
  EXPECT_GT(std::abs(psnr_of("neighbors") - psnr_of("zero")), 0.01);
}

TEST(Reconstructor, PaperPresetNeedsLibTorch) {
  EXPECT_THROW(Reconstructor(ObjectiveScene().scene, ShortPaperRun()),
               std::invalid_argument);
}

}  // namespace
}  // namespace structnerf
