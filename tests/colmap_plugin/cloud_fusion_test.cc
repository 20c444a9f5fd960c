#include "colmap_plugin/cloud_fusion.h"

#include "colmap_plugin/colmap_compat.h"
#include "colmap_plugin/input_check.h"
#include "tests/colmap_plugin/tiny_model.h"
#include "tests/nerf/aborting_progress.h"
#include "tests/support/file_size_limit.h"
#include "tests/support/temp_dir.h"

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <colmap/geometry/sim3.h>
#include <colmap/util/endian.h>
#include <colmap/util/ply.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace structnerf {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

// Images that see each point of a cloud, as in its .vis file.
std::vector<std::vector<uint32_t>> ReadPointsVisibility(
    const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::vector<std::vector<uint32_t>> visibility(
      colmap::ReadBinaryLittleEndian<uint64_t>(&file));
  for (std::vector<uint32_t>& image_idxs : visibility) {
    image_idxs.resize(colmap::ReadBinaryLittleEndian<uint32_t>(&file));
    for (uint32_t& image_idx : image_idxs) {
      image_idx = colmap::ReadBinaryLittleEndian<uint32_t>(&file);
    }
  }
  return visibility;
}

// A workspace of views of the plane z = 4, with exact maps.
class CloudFusionTest : public testing::Test {
 protected:
  static constexpr int kNumViews = 4;

  CloudFusionTest() : workspace_(temp_dir_ / "dense") {
    TinyModel model = MakeTinyModel(kNumViews);
    for (TinyModel::Image& image : model.images) {
      image.x *= 0.2;
    }
    model.WriteModel(workspace_.SparsePath());
    model.WriteImages(workspace_.ImagesPath());
    names_ = ImageNames(ReadModel(workspace_.SparsePath()));
    workspace_.CreateFolders(names_);
    workspace_.WriteConfigs(names_, {{1}, {0, 2}, {1, 3}, {2}});
    StereoMaps maps{64, 48, std::vector<float>(64 * 48, 4.0f), {}};
    maps.normal.resize(3 * 64 * 48, 0.0f);
    std::fill(maps.normal.begin() + 2 * 64 * 48, maps.normal.end(), -1.0f);
    for (const std::string& name : names_) {
      workspace_.WriteMaps(name, MapType::kGeometric, maps);
    }
    options_.min_num_pixels = 2;
  }

  TempDir temp_dir_;
  DenseWorkspace workspace_;
  std::vector<std::string> names_;
  colmap::mvs::StereoFusionOptions options_;
  Progress progress_;
};

// The model of a workspace moved to where geo-referenced ones are.
void MoveModel(const Eigen::Vector3d& offset, const DenseWorkspace& workspace) {
  colmap::Reconstruction model = ReadModel(workspace.SparsePath());
  model.Transform(colmap::Sim3d(1, Eigen::Quaterniond::Identity(), offset));
  std::filesystem::remove_all(workspace.SparsePath());
  std::filesystem::create_directories(workspace.SparsePath());
  model.WriteBinary(workspace.SparsePath());
}

TEST_F(CloudFusionTest, PointsLieOnThePlaneInModelUnits) {
  const size_t num_points = FuseMaps(
      workspace_, MapType::kGeometric, options_, kNumViews, &progress_);
  // Most pixels of one view, each seen by several.
  EXPECT_GT(num_points, 2000);
  EXPECT_LT(num_points, 64 * 48 * 2);
  const auto points = colmap::ReadPly(workspace_.FusedPath());
  ASSERT_EQ(points.size(), num_points);
  for (const colmap::PlyPoint& point : points) {
    EXPECT_NEAR(point.z, 4, 1e-5);
    // The field of view at that depth, of all views.
    EXPECT_GE(point.x, -32 / 60.0 * 4 - 1e-3);
    EXPECT_LE(point.x, 32 / 60.0 * 4 + 0.3 + 1e-3);
    EXPECT_LE(std::abs(point.y), 24 / 60.0 * 4 + 1e-3);
    EXPECT_NEAR(point.nz, -1, 1e-5);
  }
  EXPECT_TRUE(std::filesystem::exists(temp_dir_ / "dense/fused.ply.vis"));
  EXPECT_FALSE(std::filesystem::exists(temp_dir_ / "dense/fused.ply.partial"));
}

// Positions of a cloud that was written in double precision.
std::vector<Eigen::Vector3d> ReadFarPoints(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  size_t num_points = 0;
  bool is_double = false;
  for (std::string line; std::getline(file, line) && line != "end_header";) {
    if (line.compare(0, 15, "element vertex ") == 0) {
      num_points = std::stoul(line.substr(15));
    }
    is_double |= line == "property double x";
  }
  EXPECT_TRUE(is_double);
  std::vector<Eigen::Vector3d> points(num_points);
  for (Eigen::Vector3d& point : points) {
    file.read(reinterpret_cast<char*>(point.data()), 3 * sizeof(double));
    file.ignore(3 * sizeof(float) + 3);
  }
  EXPECT_TRUE(file.good());
  return points;
}

// A geo-referenced model: in single precision nothing would be left of it.
TEST_F(CloudFusionTest, FarModelsGiveTheSameCloudFarAway) {
  const size_t num_points = FuseMaps(
      workspace_, MapType::kGeometric, options_, kNumViews, &progress_);
  const Eigen::Vector3d offset(1.2e7, -7e6, 2e5);
  MoveModel(offset, workspace_);

  // Disparities are half pixels, so that whole columns of 48 pixels at a border
  // may be seen once more or less: two here.
  EXPECT_NEAR(
      FuseMaps(
          workspace_, MapType::kGeometric, options_, kNumViews, &progress_),
      num_points,
      2 * 48);
  const auto points = ReadFarPoints(workspace_.FusedPath());
  const auto visibility = ReadPointsVisibility(workspace_.FusedPath() + ".vis");
  ASSERT_EQ(visibility.size(), points.size());
  const colmap::Reconstruction far_model = ReadModel(workspace_.SparsePath());
  const auto image_ids = RegisteredImageIds(far_model);
  for (size_t i = 0; i < points.size(); ++i) {
    EXPECT_NEAR(points[i].z() - offset.z(), 4, 1e-5);
    for (const uint32_t image_idx : visibility[i]) {
      // Where the image sees it.
      const Eigen::Vector3d in_view =
          far_model.Image(image_ids.at(image_idx)).CamFromWorld() * points[i];
      EXPECT_NEAR(in_view.x() / in_view.z() * 60, 0, 33);
    }
  }
  EXPECT_TRUE(colmap::ReadPly(workspace_.FusedPath()).size() == points.size());
  EXPECT_FALSE(std::filesystem::exists(workspace_.ReportFolder() + "/centred"));
}

TEST_F(CloudFusionTest, CacheGivesTheSameCloud) {
  const size_t num_points = FuseMaps(
      workspace_, MapType::kGeometric, options_, kNumViews, &progress_);
  options_.use_cache = true;
  options_.cache_size = 1e-4;
  EXPECT_NEAR(
      FuseMaps(
          workspace_, MapType::kGeometric, options_, kNumViews, &progress_),
      num_points,
      0.05 * num_points);
}

TEST_F(CloudFusionTest, TooFewViewsGiveAnEmptyCloud) {
  options_.min_num_pixels = 100;
  EXPECT_EQ(
      FuseMaps(
          workspace_, MapType::kGeometric, options_, kNumViews, &progress_),
      0);
  EXPECT_THAT(colmap::ReadPly(workspace_.FusedPath()), IsEmpty());
}

// Not a byte may be missing, near the origin and far from it.
TEST_F(CloudFusionTest, FullDiskLeavesNoHalfCloud) {
  for (const double distance : {0.0, 1e7}) {
    MoveModel({distance, 0, 0}, workspace_);
    FuseMaps(workspace_, MapType::kGeometric, options_, kNumViews, &progress_);
    const size_t num_bytes = std::filesystem::file_size(workspace_.FusedPath());
    std::filesystem::remove(workspace_.FusedPath());
    const ScopedFileSizeLimit limit(num_bytes - 1);
    try {
      FuseMaps(
          workspace_, MapType::kGeometric, options_, kNumViews, &progress_);
      ADD_FAILURE();
    } catch (const std::runtime_error& error) {
      EXPECT_THAT(error.what(), HasSubstr("fused.ply could not be written"));
    }
    EXPECT_FALSE(std::filesystem::exists(workspace_.FusedPath()));
  }
}

TEST_F(CloudFusionTest, AbortWritesNothing) {
  AbortingProgress progress;
  EXPECT_THROW(
      FuseMaps(workspace_, MapType::kGeometric, options_, kNumViews, &progress),
      Aborted);
  EXPECT_FALSE(std::filesystem::exists(workspace_.FusedPath()));
}

TEST(EmptyCloudText, OffersWhatCanHelp) {
  const std::string unconfirmed =
      EmptyCloudText(MapType::kGeometric, /*has_geometric=*/false, 3);
  EXPECT_THAT(unconfirmed, HasSubstr("confirmed by other views"));
  EXPECT_THAT(unconfirmed, HasSubstr("input_type photometric"));
  EXPECT_THAT(unconfirmed, HasSubstr("min_num_pixels 2."));
  const std::string unseen =
      EmptyCloudText(MapType::kGeometric, /*has_geometric=*/true, 3);
  EXPECT_THAT(unseen, HasSubstr("seen by 3 pixels"));
  // Nothing is offered that is so already.
  const std::string photometric =
      EmptyCloudText(MapType::kPhotometric, /*has_geometric=*/false, 1);
  EXPECT_THAT(photometric, HasSubstr("seen by 1 pixels"));
  EXPECT_THAT(photometric, Not(HasSubstr("--")));
}

TEST(MinNumPixels, GrowsWithTheViewsUpToColmapsDefault) {
  colmap::mvs::StereoFusionOptions options;
  options.min_num_pixels = 0;
  EXPECT_EQ(MinNumPixels(options, 2), 2);
  EXPECT_EQ(MinNumPixels(options, 29), 2);
  EXPECT_EQ(MinNumPixels(options, 30), 3);
  EXPECT_EQ(MinNumPixels(options, 50), 5);
  EXPECT_EQ(MinNumPixels(options, 1000), 5);
  options.max_num_pixels = 3;
  EXPECT_EQ(MinNumPixels(options, 1000), 3);
  options.max_num_pixels = colmap::mvs::StereoFusionOptions().max_num_pixels;
  options.min_num_pixels = 7;
  EXPECT_EQ(MinNumPixels(options, 50), 7);
}

TEST(EstimateFusionMemory, MorePixelsPerPointMakeFewerPoints) {
  const std::vector<PinholeCamera> cameras(100, {640, 480, 1, 1, 0, 0});
  colmap::mvs::StereoFusionOptions options;
  options.min_num_pixels = 2;
  const size_t many_points = EstimateFusionMemory(options, cameras);
  options.min_num_pixels = 5;
  const size_t few_points = EstimateFusionMemory(options, cameras);
  EXPECT_LT(few_points, many_points);
  options.min_num_pixels = 0;  // as it will be chosen
  EXPECT_EQ(EstimateFusionMemory(options, cameras), few_points);
}

TEST(FitFusionIntoMemory, ChangesNothingThatFits) {
  const std::vector<PinholeCamera> cameras(10, {640, 480, 1, 1, 0, 0});
  colmap::mvs::StereoFusionOptions options;
  EXPECT_EQ(FitFusionIntoMemory(cameras, size_t{1} << 30, &options), "");
  EXPECT_FALSE(options.use_cache);
  EXPECT_EQ(options.max_image_size, -1);
}

TEST(FitFusionIntoMemory, CachesThenReducesThenRefuses) {
  const std::vector<PinholeCamera> cameras(100, {4000, 3000, 1, 1, 0, 0});
  colmap::mvs::StereoFusionOptions options;
  const size_t full = EstimateFusionMemory(options, cameras);
  EXPECT_GT(full, 100 * 4000 * 3000 * size_t{20});

  EXPECT_THAT(FitFusionIntoMemory(cameras, full - 1, &options),
              HasSubstr("cache"));
  EXPECT_TRUE(options.use_cache);
  EXPECT_EQ(options.max_image_size, -1);
  EXPECT_LT(EstimateFusionMemory(options, cameras), full);

  options = colmap::mvs::StereoFusionOptions();
  const size_t limit = full / 20;
  EXPECT_THAT(FitFusionIntoMemory(cameras, limit, &options),
              HasSubstr("reduced to"));
  EXPECT_LT(options.max_image_size, 4000);
  EXPECT_LE(EstimateFusionMemory(options, cameras), limit);

  EXPECT_THROW(FitFusionIntoMemory(cameras, 1000, &options),
               std::runtime_error);
}

}  // namespace
}  // namespace structnerf
