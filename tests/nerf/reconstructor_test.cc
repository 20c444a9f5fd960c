// The method from a scene to maps, on a small made-up room. What it says about
// scenes that are wrong or odd is in reconstructor_input_test.cc.

#include "nerf/reconstructor.h"

#include "nerf/train/depth_prior.h"
#include "nerf/util/quantile.h"
#include "tests/support/synthetic_room.h"
#include "tests/support/temp_dir.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

namespace structnerf {
namespace {

ReconstructionOptions SmallOptions() {
  ReconstructionOptions options;
  options.field.log2_table_size = 15;
  options.sampling.cache_resolution = 64;
  options.training.num_steps = 200;
  options.training.rays_per_step = 256;
  options.training.num_threads = 2;
  return options;
}

bool AreEqual(const std::vector<float>& a, const std::vector<float>& b) {
  return a.size() == b.size() &&
         std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0;
}

bool AreEqual(const std::vector<DenseMaps>& a,
              const std::vector<DenseMaps>& b) {
  bool are_equal = a.size() == b.size();
  for (size_t v = 0; are_equal && v < a.size(); ++v) {
    are_equal = AreEqual(a[v].depth, b[v].depth) &&
                AreEqual(a[v].normal, b[v].normal) &&
                AreEqual(a[v].relative_std, b[v].relative_std);
  }
  return are_equal;
}

// Maps of the first views.
std::vector<DenseMaps> Render(const Reconstructor& reconstructor,
                              const size_t num_views) {
  std::vector<DenseMaps> maps;
  Progress progress;
  for (size_t v = 0; v < num_views; ++v) {
    maps.push_back(reconstructor.RenderView(v, &progress));
  }
  return maps;
}

std::vector<DenseMaps> TrainAndRender(const Scene& scene,
                                      const ReconstructionOptions& options,
                                      const size_t num_views) {
  Reconstructor reconstructor(scene, options);
  Progress progress;
  reconstructor.Train(&progress);
  return Render(reconstructor, num_views);
}

// The room and what two threads make of it, once for all tests.
class ReconstructorTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    SyntheticRoomOptions options;
    options.num_views = 8;
    options.width = 96;
    options.height = 72;
    room_ = std::make_unique<SyntheticRoom>(MakeSyntheticRoom(options));
    scene_ = std::make_unique<Scene>(MakeScene(*room_));
    maps_ = std::make_unique<std::vector<DenseMaps>>(
        TrainAndRender(*scene_, SmallOptions(), scene_->views.size()));
  }

  static void TearDownTestSuite() {
    maps_.reset();
    scene_.reset();
    room_.reset();
  }

  static std::unique_ptr<SyntheticRoom> room_;
  static std::unique_ptr<Scene> scene_;
  static std::unique_ptr<std::vector<DenseMaps>> maps_;
};

std::unique_ptr<SyntheticRoom> ReconstructorTest::room_;
std::unique_ptr<Scene> ReconstructorTest::scene_;
std::unique_ptr<std::vector<DenseMaps>> ReconstructorTest::maps_;

TEST_F(ReconstructorTest, DepthIsFarBetterThanInterpolatedPoints) {
  std::vector<double> errors;
  std::vector<double> certain_errors;
  std::vector<double> interpolation_errors;
  const auto samples = CollectDepthSamples(*scene_);
  for (size_t v = 0; v < scene_->views.size(); ++v) {
    const DenseMaps& maps = (*maps_)[v];
    const RoomTruth truth =
        CastTruth(*room_, static_cast<int>(v), PixelPoint::kInteger);
    ASSERT_EQ(maps.width, truth.width);
    ASSERT_EQ(maps.height, truth.height);
    std::vector<float> relative_stds = maps.relative_std;
    const float median_std = Quantile(&relative_stds, 0.5);
    for (int row = 0; row < maps.height; ++row) {
      for (int col = 0; col < maps.width; ++col) {
        const size_t pixel = static_cast<size_t>(row) * maps.width + col;
        // Holes count as wrong.
        errors.push_back(std::abs(maps.depth[pixel] / truth.depth[pixel] - 1));
        if (maps.relative_std[pixel] < median_std) {
          certain_errors.push_back(errors.back());
        }
        interpolation_errors.push_back(std::abs(
            InterpolateDepth(samples[v], col, row) / truth.depth[pixel] - 1));
      }
    }
  }
  // About 3.2 %, 9 % and 11 % when this was written.
  const double error = Quantile(&errors, 0.5);
  EXPECT_LT(error, 0.06);
  EXPECT_LT(Quantile(&errors, 0.75), 0.16);
  EXPECT_LT(error, 0.6 * Quantile(&interpolation_errors, 0.5));
  EXPECT_LT(Quantile(&certain_errors, 0.5), 0.85 * error);
}

TEST_F(ReconstructorTest, MapsKeepTheirPromises) {
  std::vector<double> angles;
  size_t num_pixels = 0;
  size_t num_valid = 0;
  for (size_t v = 0; v < scene_->views.size(); ++v) {
    const DenseMaps& maps = (*maps_)[v];
    const PinholeCamera& camera = scene_->views[v].camera;
    const RoomTruth truth =
        CastTruth(*room_, static_cast<int>(v), PixelPoint::kInteger);
    const size_t plane = maps.depth.size();
    ASSERT_EQ(plane, camera.NumPixels());
    ASSERT_EQ(maps.normal.size(), 3 * plane);
    ASSERT_EQ(maps.relative_std.size(), plane);
    num_pixels += plane;
    for (size_t i = 0; i < plane; ++i) {
      const Eigen::Vector3d normal(
          maps.normal[i], maps.normal[plane + i], maps.normal[2 * plane + i]);
      ASSERT_TRUE(std::isfinite(maps.depth[i]));
      ASSERT_TRUE(std::isfinite(maps.relative_std[i]));
      ASSERT_GE(maps.relative_std[i], 0);
      if (maps.depth[i] == 0) {
        ASSERT_EQ(normal.norm(), 0);
        continue;
      }
      ++num_valid;
      ASSERT_GT(maps.depth[i], 0);
      ASSERT_LE(maps.relative_std[i],
                SmallOptions().extraction.max_relative_std);
      ASSERT_NEAR(normal.norm(), 1, 1e-5);
      const Eigen::Vector3d ray(
          (static_cast<int>(i) % maps.width - camera.cx) / camera.fx,
          (static_cast<int>(i) / maps.width - camera.cy) / camera.fy,
          1);
      ASSERT_LT(normal.dot(ray), 0);
      const Eigen::Vector3d expected(truth.normal[i],
                                     truth.normal[plane + i],
                                     truth.normal[2 * plane + i]);
      angles.push_back(
          std::acos(std::min(1.0, std::max(-1.0, normal.dot(expected)))) * 180 /
          M_PI);
    }
  }
  EXPECT_GT(num_valid, 0.8 * num_pixels);
  // About 32 degrees when this was written; normals by chance give 60.
  EXPECT_LT(Quantile(&angles, 0.5), 45);
}

TEST_F(ReconstructorTest, NumberOfThreadsChangesNothing) {
  ReconstructionOptions options = SmallOptions();
  for (const int num_threads : {1, 3}) {
    options.training.num_threads = num_threads;
    EXPECT_TRUE(AreEqual(TrainAndRender(*scene_, options, scene_->views.size()),
                         *maps_))
        << num_threads << " threads";
  }
}

TEST_F(ReconstructorTest, SeedChangesTheResult) {
  ReconstructionOptions options = SmallOptions();
  options.training.num_steps = 20;
  const auto maps = TrainAndRender(*scene_, options, 1);
  EXPECT_TRUE(AreEqual(TrainAndRender(*scene_, options, 1), maps));
  options.training.seed = 1;
  EXPECT_FALSE(AreEqual(TrainAndRender(*scene_, options, 1), maps));
}

// Geo-referenced, in other units: the same field, and depth in those units.
TEST_F(ReconstructorTest, WorldMayBeAnywhereInAnyUnits) {
  const double scale = 1000;
  const Eigen::Vector3d offset(1e6, -1e6, 1e6);
  Scene moved = *scene_;
  for (View& view : moved.views) {
    const Eigen::Vector3d center = scale * view.ProjectionCenter() + offset;
    view.cam_from_world_translation = -(view.cam_from_world_rotation * center);
  }
  for (SparsePoint& point : moved.points) {
    point.xyz = scale * point.xyz + offset;
  }
  const auto maps = TrainAndRender(moved, SmallOptions(), 3);
  std::vector<double> differences;
  for (size_t v = 0; v < maps.size(); ++v) {
    for (size_t i = 0; i < maps[v].depth.size(); ++i) {
      const double depth = (*maps_)[v].depth[i];
      if (depth > 0) {
        differences.push_back(std::abs(maps[v].depth[i] / (scale * depth) - 1));
      }
    }
  }
  EXPECT_LT(Quantile(&differences, 0.5), 1e-3);
}

class RecordingProgress : public Progress {
 public:
  void Report(const ProgressUpdate& update) override {
    updates.push_back(update);
    last_fraction = update.fraction;
  }
  bool ShouldStop() override { return last_fraction >= stop_at; }
  bool ShouldAbort() override { return last_fraction >= abort_at; }

  std::vector<ProgressUpdate> updates;
  double last_fraction = 0;
  double stop_at = 2;
  double abort_at = 2;
};

TEST_F(ReconstructorTest, ReportsAndSummary) {
  ReconstructionOptions options = SmallOptions();
  options.training.num_steps = 60;
  options.training.test_every = 4;
  Reconstructor reconstructor(*scene_, options);
  RecordingProgress progress;
  reconstructor.Train(&progress);
  double last_fraction = 0;
  for (const ProgressUpdate& update : progress.updates) {
    EXPECT_GE(update.fraction, last_fraction);
    last_fraction = update.fraction;
  }
  EXPECT_EQ(last_fraction, 1);
  const TrainingSummary& summary = reconstructor.Summary();
  EXPECT_EQ(summary.num_steps, 60);
  EXPECT_FALSE(summary.stopped_early);
  EXPECT_GT(summary.final_loss, 0);
  EXPECT_GT(summary.held_out_psnr, 10);
  EXPECT_LT(summary.held_out_psnr, 40);
  EXPECT_EQ(summary.num_rays, 60u * 256);
  EXPECT_GT(summary.num_parameters, 100000u);
  for (const auto& [name, count] : summary.guard_counts) {
    EXPECT_EQ(count, 0) << name;
  }
}

// What a field learns until it is stopped is kept, rendered and saved.
TEST_F(ReconstructorTest, StopsEarlyWithWhatWasLearned) {
  ReconstructionOptions options = SmallOptions();
  // At the stop, the second level is just coming in and finer ones are off.
  options.training.coarse_to_fine_fraction = 0.27;
  Reconstructor reconstructor(*scene_, options);
  RecordingProgress progress;
  progress.stop_at = 0.1;
  reconstructor.Train(&progress);
  EXPECT_TRUE(reconstructor.Summary().stopped_early);
  EXPECT_LT(reconstructor.Summary().num_steps, 40);
  EXPECT_GE(reconstructor.Summary().num_steps, 20);
  const auto maps = Render(reconstructor, 2);
  size_t num_valid = 0;
  for (const float depth : maps[0].depth) {
    num_valid += depth > 0;
  }
  EXPECT_GT(num_valid, 0.5 * maps[0].depth.size());

  const TempDir folder;
  reconstructor.SaveField(folder / "field.bin");
  Reconstructor loaded(*scene_, SmallOptions());
  loaded.LoadField(folder / "field.bin");
  EXPECT_TRUE(AreEqual(Render(loaded, 2), maps));
}

TEST_F(ReconstructorTest, AbortsWhenTold) {
  Reconstructor reconstructor(*scene_, SmallOptions());
  RecordingProgress progress;
  progress.abort_at = 0.1;
  EXPECT_THROW(reconstructor.Train(&progress), Aborted);
  EXPECT_LT(progress.last_fraction, 0.2);
  EXPECT_THROW(reconstructor.RenderView(0, &progress), Aborted);
}

// Rendering needs a cache that takes long to make.
TEST_F(ReconstructorTest, AbortsAfterTheLastStep) {
  Reconstructor reconstructor(*scene_, SmallOptions());
  RecordingProgress progress;
  progress.abort_at = 1;
  EXPECT_THROW(reconstructor.Train(&progress), Aborted);
  EXPECT_EQ(progress.last_fraction, 1);
}

TEST_F(ReconstructorTest, BeingWatchedChangesNothing) {
  class WatchingProgress : public Progress {
   public:
    int PreviewViewIdx() override { return 1; }
    void ShowPreview(const Preview& preview) override {
      EXPECT_EQ(preview.view_idx, 1);
      ++num_previews;
    }
    int num_previews = 0;
  };
  Reconstructor reconstructor(*scene_, SmallOptions());
  WatchingProgress progress;
  reconstructor.Train(&progress);
  EXPECT_GE(progress.num_previews, 1);
  EXPECT_TRUE(AreEqual(Render(reconstructor, scene_->views.size()), *maps_));
}

TEST_F(ReconstructorTest, SavedFieldGivesTheSameMaps) {
  const TempDir folder;
  const std::string path = folder / "field.bin";
  ReconstructionOptions options = SmallOptions();
  options.training.num_steps = 50;
  Reconstructor reconstructor(*scene_, options);
  Progress progress;
  reconstructor.Train(&progress);
  reconstructor.SaveField(path);
  const auto maps = Render(reconstructor, 2);
  {
    Reconstructor loaded(*scene_, options);
    loaded.LoadField(path);
    EXPECT_TRUE(AreEqual(Render(loaded, 2), maps));
  }
  options.field.hidden_width = 16;
  Reconstructor other_field(*scene_, options);
  EXPECT_THROW(other_field.LoadField(path), std::runtime_error);
}

}  // namespace
}  // namespace structnerf
