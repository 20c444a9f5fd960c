#include "colmap_plugin/run_plan.h"

#include "colmap_plugin/input_check.h"
#include "colmap_plugin/memory_budget.h"
#include "nerf/reconstructor.h"
#include "tests/colmap_plugin/tiny_model.h"
#include "tests/support/temp_dir.h"

#include <algorithm>
#include <stdexcept>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace structnerf {
namespace {

using testing::HasSubstr;

std::vector<PinholeCamera> MakeCameras(int num_views) {
  return std::vector<PinholeCamera>(num_views, {2000, 1500, 1, 1, 0, 0});
}

TEST(MemoryLimit, IsThreeQuartersUnlessGiven) {
  EXPECT_EQ(MemoryLimit(2), size_t{2} << 30);
  EXPECT_NEAR(static_cast<double>(MemoryLimit(-1)),
              0.75 * static_cast<double>(AvailableMemory()),
              4);
}

TEST(CurrentMemory, FollowsWhatIsHeld) {
#ifdef __SANITIZE_ADDRESS__
  GTEST_SKIP() << "the address sanitizer keeps freed memory";
#endif
  const size_t before = CurrentMemory();
  {
    const std::vector<char> held(100 << 20, 1);
    EXPECT_GT(CurrentMemory(), before + (90 << 20));
  }
  EXPECT_LT(CurrentMemory(), before + (10 << 20));
  EXPECT_GT(PeakMemory(), before + (90 << 20));
  EXPECT_LT(PeakMemory(), AvailableMemory());
}

TEST(PlanMemory, KeepsWhatFits) {
  StructNerfOptions options;
  options.reconstruction.training.max_image_size = 500;
  options.max_memory_gb = 1000;
  const MemoryPlan plan = PlanMemory(options, MakeCameras(20));
  EXPECT_EQ(plan.max_image_size, 500);
  EXPECT_EQ(plan.note, "");
  EXPECT_LT(plan.depth_map_bytes, plan.limit);
  EXPECT_LT(plan.expected, plan.limit);
  // Maps of more views are held at once, and fused.
  EXPECT_GT(PlanMemory(options, MakeCameras(40)).expected, plan.expected);
}

TEST(PlanMemory, ReducesImagesAndSaysSo) {
  StructNerfOptions options;
  options.reconstruction.training.max_image_size = 2000;
  const auto cameras = MakeCameras(3000);
  ReconstructionOptions small = options.reconstruction;
  small.training.max_image_size = 500;
  options.max_memory_gb =
      Reconstructor::EstimateMemory(small, 3000, cameras[0]) / kBytesPerGb + 1;
  const MemoryPlan plan = PlanMemory(options, cameras);
  EXPECT_LT(plan.max_image_size, 2000);
  EXPECT_GE(plan.max_image_size, 300);
  EXPECT_THAT(plan.note, HasSubstr(std::to_string(plan.max_image_size)));
  EXPECT_THAT(plan.note, HasSubstr("2000"));
}

TEST(PlanMemory, KeepsThePixelsThatCanBeTrainedOn) {
  StructNerfOptions options;
  options.reconstruction.training.max_image_size = 1600;
  options.max_memory_gb = 1000;
  const MemoryPlan plan = PlanMemory(options, MakeCameras(600));
  EXPECT_EQ(plan.max_image_size, 1200);
  EXPECT_THAT(plan.note, HasSubstr("1200 instead of 1600 pixels because"));
}

TEST(PlanMemory, ReadsAsManyImagesAtOnceAsFit) {
  StructNerfOptions options;
  options.workspace_path = "dense";
  options.max_memory_gb = 1000;
  EXPECT_EQ(PlanMemory(options, MakeCameras(1)).num_decoded_images, 1);
  const int num_cores =
      std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  EXPECT_EQ(PlanMemory(options, MakeCameras(1000)).num_decoded_images,
            std::min(1000, num_cores));
  options.reconstruction.training.num_threads = 1;
  EXPECT_EQ(PlanMemory(options, MakeCameras(1000)).num_decoded_images, 1);
}

TEST(PlanMemory, CountsWhatTheCheckOfAViewHolds) {
  StructNerfOptions options;
  // 2 GB are what training needs, 16 GB the maps of a view and its sources, and
  // somewhat more what is made of them and known about pixels that other views
  // confirm.
  const std::vector<PinholeCamera> cameras(20, {10000, 10000, 1, 1, 0, 0});
  options.max_memory_gb = 28;
  EXPECT_THROW(PlanMemory(options, cameras), std::runtime_error);
  options.max_memory_gb = 42;
  EXPECT_NO_THROW(PlanMemory(options, cameras));
}

TEST(PlanMemory, RefusesWhatCannotFit) {
  StructNerfOptions options;
  options.max_memory_gb = 0.01;
  try {
    PlanMemory(options, MakeCameras(20));
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr("--StructNeRF.max_memory_gb"));
  }
}

TEST(CheckDiskSpace, RefusesMoreThanTheDiskHas) {
  const TempDir temp_dir;
  EXPECT_NO_THROW(CheckDiskSpace(temp_dir / "not/there", MakeCameras(1), 0, 0));
  // What is there already needs no room.
  EXPECT_NO_THROW(CheckDiskSpace(temp_dir / "not/there",
                                 MakeCameras(1),
                                 size_t{1} << 60,
                                 size_t{1} << 60));
  try {
    CheckDiskSpace(temp_dir / "not/there", MakeCameras(1), size_t{1} << 60, 0);
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr(temp_dir / "not/there"));
  }
}

TEST(UndistortedCameras, AreInModelOrder) {
  const TempDir temp_dir;
  TinyModel model = MakeTinyModel(2);
  model.cameras.push_back({"SIMPLE_RADIAL", 64, 48, {60, 32, 24, 0.3}});
  model.images[1].camera_idx = 1;
  model.WriteModel(temp_dir.Path());
  const auto cameras = UndistortedCameras(ReadModel(temp_dir.Path()));
  ASSERT_EQ(cameras.size(), 2);
  EXPECT_EQ(cameras[0].width, 64);
  EXPECT_NE(cameras[1].width, 64);
  EXPECT_NEAR(cameras[1].cx, 0.5 * cameras[1].width, 1e-9);
}

}  // namespace
}  // namespace structnerf
