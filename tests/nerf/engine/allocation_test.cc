// Once a step of every kind was taken, training must not touch the heap: this
// program counts all allocations.

#include "nerf/engine/grid_engine.h"
#include "tests/nerf/engine/random_scene.h"

#include <atomic>
#include <cstddef>

#include <dlfcn.h>
#include <gtest/gtest.h>

namespace {

std::atomic<size_t> num_allocations{0};

template <typename Function>
Function* NextFunction(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

}  // namespace

// operator new comes down to these, and so does what AlignedBuffer does.
extern "C" void* malloc(const size_t size) noexcept {
  static const auto next = NextFunction<void*(size_t)>("malloc");
  ++num_allocations;
  return next(size);
}

extern "C" void* aligned_alloc(const size_t alignment,
                               const size_t size) noexcept {
  static const auto next = NextFunction<void*(size_t, size_t)>("aligned_alloc");
  ++num_allocations;
  return next(alignment, size);
}

namespace structnerf {
namespace {

TEST(Allocation, TrainingStepsDoNotAllocate) {
  for (const int num_threads : {1, 3}) {
    EngineOptions options;
    options.field.log2_table_size = 11;
    options.sampling.cache_resolution = 32;
    options.num_threads = num_threads;
    const auto engine = MakeFusedEngine(options);
    const auto objectives = RandomObjectives(*engine, 1, kMaxTileRays);
    StepParameters step;
    step.num_tiles = 20;
    step.level_weights = {1.0f, 1.0f, 0.5f, 0.0f};
    const auto train = [&] {
      for (; step.step % 5 != 4; ++step.step) {
        engine->Accumulate(step, objectives);
        engine->Update(1e-2f, 1e-3f);
        engine->RefreshDensityCache(0.9f);
      }
    };
    train();
    ++step.step;
    const size_t before = num_allocations;
    EXPECT_GT(before, 0u);
    train();
    EXPECT_EQ(num_allocations, before);
  }
}

}  // namespace
}  // namespace structnerf
