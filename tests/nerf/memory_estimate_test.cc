#include "nerf/reconstructor.h"
#include "tests/nerf/plane_scene.h"

#include <functional>
#include <utility>

#include <gtest/gtest.h>
#include <malloc.h>

namespace structnerf {
namespace {

TEST(EstimateMemory, GrowsWithEverythingThatCosts) {
  const ReconstructionOptions options;
  const PinholeCamera camera = MakeCamera(640, 480, 500);
  const size_t base = Reconstructor::EstimateMemory(options, 20, camera);
  EXPECT_GT(base, size_t{10} << 20);
  EXPECT_LT(base, size_t{1} << 30);
  EXPECT_GT(Reconstructor::EstimateMemory(options, 2000, camera), base);
  // The maps of a view have its size, not that of the training images.
  EXPECT_GT(
      Reconstructor::EstimateMemory(options, 20, MakeCamera(6400, 4800, 5000)),
      base);
  const auto expect_more =
      [&](const std::function<void(ReconstructionOptions*)>& change) {
        ReconstructionOptions more;
        change(&more);
        EXPECT_GT(Reconstructor::EstimateMemory(more, 20, camera), base);
      };
  expect_more([](ReconstructionOptions* o) { o->field.num_levels = 6; });
  expect_more([](ReconstructionOptions* o) { o->field.log2_table_size = 20; });
  expect_more([](ReconstructionOptions* o) { o->sampling.num_samples = 64; });
  expect_more(
      [](ReconstructionOptions* o) { o->sampling.cache_resolution = 256; });
  expect_more(
      [](ReconstructionOptions* o) { o->training.rays_per_step = 8192; });
  expect_more(
      [](ReconstructionOptions* o) { o->training.max_image_size = 640; });
  expect_more([](ReconstructionOptions* o) { o->loss.match_weight = 1; });
}

TEST(EstimateMemory, OfTheMlpIsThatOfItsNetworks) {
  ReconstructionOptions options;
  options.field.type = "mlp";
  const PinholeCamera camera = MakeCamera(640, 480, 500);
  const size_t base = Reconstructor::EstimateMemory(options, 20, camera);
  // Grid options play no role.
  options.field.log2_table_size = 24;
  options.sampling.cache_resolution = 512;
  EXPECT_EQ(Reconstructor::EstimateMemory(options, 20, camera), base);
  options.field.mlp_width = 512;
  EXPECT_GT(Reconstructor::EstimateMemory(options, 20, camera), base);
  // So many samples that one tile of rays is more than a batch.
  options.field.mlp_width = 256;
  options.sampling.num_fine_samples = 1024;
  EXPECT_GT(Reconstructor::EstimateMemory(options, 20, camera), 1.5 * base);
}

// Only the C library keeps count.
#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__)
size_t NumAllocatedBytes() {
  const struct mallinfo2 info = mallinfo2();
  return info.uordblks + info.hblkhd;
}

// A run must not need much more than was promised.
TEST(EstimateMemory, CoversWhatIsAllocated) {
  const size_t before = NumAllocatedBytes();
  if (before == 0) {
    GTEST_SKIP() << "the allocator keeps no count";
  }
  struct Case {
    int num_views;
    int size;
    int rays_per_step;
    int log2_table_size;
    int cache_resolution;
  };
  // What dominates: images, the rays of a step, the field, the density cache.
  for (const Case& c : {Case{40, 200, 64, 12, 16},
                        Case{4, 32, 8192, 12, 16},
                        Case{4, 32, 64, 18, 16},
                        Case{4, 32, 64, 12, 256}}) {
    ReconstructionOptions options;
    options.training.num_steps = 2;
    options.training.num_threads = 1;
    options.training.rays_per_step = c.rays_per_step;
    options.field.max_resolution = 512;
    options.field.log2_table_size = c.log2_table_size;
    options.sampling.cache_resolution = c.cache_resolution;
    Scene scene;
    for (int v = 0; v < c.num_views; ++v) {
      scene.views.push_back(MakeView(
          "view", MakeCamera(c.size, c.size, c.size), {0.02 * v, 0, 0}));
      View& view = scene.views.back();
      view.image = PlainImage(c.size, c.size, 100);
      view.mask.assign(c.size * c.size, 255);
      view.segments.assign(c.size * c.size, 0);
    }
    scene.points = {MakePoint(scene, {0, 0, 4}, {0, 1})};
    const size_t estimate = Reconstructor::EstimateMemory(
        options, c.num_views, MakeCamera(c.size, c.size, c.size));
    Reconstructor reconstructor(std::move(scene), options);
    Progress progress;
    reconstructor.Train(&progress);
    const DenseMaps maps = reconstructor.RenderView(0, &progress);
    const size_t allocated = NumAllocatedBytes() - before;
    // A few MiB of small things are not counted.
    EXPECT_LT(allocated, 1.1 * estimate + (4 << 20));
    EXPECT_GT(allocated, 0.15 * estimate);
  }
}
#endif

}  // namespace
}  // namespace structnerf
