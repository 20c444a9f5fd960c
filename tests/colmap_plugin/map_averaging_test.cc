#include "colmap_plugin/map_averaging.h"

#include "tests/support/temp_dir.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include <colmap/mvs/consistency_graph.h>

#include <gtest/gtest.h>

namespace structnerf {
namespace {

constexpr int kWidth = 32;
constexpr int kHeight = 24;
constexpr int kNumPixels = kWidth * kHeight;

// In the left quarter, and right of the middle.
constexpr int kUnconfirmedPixel = kHeight / 2 * kWidth + kWidth / 4 - 2;
constexpr int kConfirmedPixel = kHeight / 2 * kWidth + 3 * kWidth / 4;

// Three views side by side of a wall at depth 10, which they have at 9.9, 10.1
// and 10.2. The left quarter of the first is not confirmed.
class AverageMapsTest : public testing::Test {
 protected:
  AverageMapsTest() : workspace_(temp_dir_ / "dense") {
    options_.image_names = {"0.png", "1.png", "2.png"};
    options_.max_bytes = size_t{1} << 20;
    workspace_.CreateFolders(options_.image_names);
    for (int v = 0; v < 3; ++v) {
      View& view = scene_.views.emplace_back();
      view.camera = {kWidth, kHeight, 40.0, 40.0, 0.5 * kWidth, 0.5 * kHeight};
      view.cam_from_world_translation = {-0.5 * v, 0, 0};
    }
    SetUpMaps();
  }

  void SetUpMaps() {
    for (int v = 0; v < 3; ++v) {
      StereoMaps maps{kWidth, kHeight, {}, std::vector<float>(3 * kNumPixels)};
      maps.depth.assign(kNumPixels, kDepths[v]);
      std::fill(maps.normal.begin() + 2 * kNumPixels, maps.normal.end(), -1.0f);
      workspace_.WriteMaps(
          options_.image_names[v], MapType::kPhotometric, maps);
      std::vector<uint8_t> is_confirmed(kNumPixels, 1);
      for (int pixel = 0; v == 0 && pixel < kNumPixels; ++pixel) {
        is_confirmed[pixel] = pixel % kWidth >= kWidth / 4;
      }
      maps.KeepOnly(is_confirmed);
      workspace_.WriteMaps(options_.image_names[v], MapType::kGeometric, maps);
    }
  }

  std::vector<size_t> Average() {
    Progress silent;
    StageProgress stage("Test", &silent);
    return AverageMaps(
        options_, scene_, {{1, 2}, {0, 2}, {0, 1}}, workspace_, &stage);
  }

  StereoMaps Read(const int view_idx, const MapType type) const {
    return workspace_.ReadMaps(options_.image_names[view_idx], type);
  }

  static constexpr float kDepths[3] = {9.9f, 10.1f, 10.2f};

  const TempDir temp_dir_;
  const DenseWorkspace workspace_;
  Scene scene_;
  MapAveragingOptions options_;
};

TEST_F(AverageMapsTest, EveryViewHasTheMeanOfWhatTheyHadBefore) {
  Average();
  for (int v = 0; v < 3; ++v) {
    const StereoMaps photometric = Read(v, MapType::kPhotometric);
    const StereoMaps geometric = Read(v, MapType::kGeometric);
    EXPECT_NEAR(
        photometric.depth[kConfirmedPixel], (9.9 + 10.1 + 10.2) / 3, 1e-4);
    EXPECT_EQ(geometric.depth[kConfirmedPixel],
              photometric.depth[kConfirmedPixel]);
    EXPECT_EQ(geometric.normal[2 * kNumPixels + kConfirmedPixel], -1);
  }
}

// Two others confirm what has no confirmed depth of its own.
TEST_F(AverageMapsTest, GeometricIsWhatEnoughViewsConfirm) {
  for (const int min_num_consistent : {3, 2}) {
    SetUpMaps();
    options_.extraction.min_num_consistent = min_num_consistent;
    const std::vector<size_t> num_geometric = Average();
    const float mean = Read(0, MapType::kPhotometric).depth[kUnconfirmedPixel];
    EXPECT_NEAR(mean, (10.1 + 10.2) / 2, 1e-4);
    const StereoMaps geometric = Read(0, MapType::kGeometric);
    const bool is_geometric = min_num_consistent == 2;
    EXPECT_EQ(geometric.depth[kUnconfirmedPixel], is_geometric ? mean : 0);
    EXPECT_EQ(geometric.normal[2 * kNumPixels + kUnconfirmedPixel],
              is_geometric ? -1 : 0);
    for (int v = 0; v < 3; ++v) {
      EXPECT_EQ(Read(v, MapType::kGeometric).NumDepths(), num_geometric[v]);
    }
  }
}

TEST_F(AverageMapsTest, GraphAndConfidenceAreOfTheMean) {
  options_.extraction.min_num_consistent = 3;
  Average();
  colmap::mvs::ConsistencyGraph graph;
  graph.Read(workspace_.ConsistencyGraphPath("0.png"));
  const auto num_views = [&](const int pixel) {
    int num = 0;
    const int* views = nullptr;
    graph.GetImageIdxs(pixel / kWidth, pixel % kWidth, &num, &views);
    return num;
  };
  EXPECT_EQ(num_views(kConfirmedPixel), 2);
  EXPECT_EQ(num_views(kUnconfirmedPixel), 0);
  const std::vector<float> confidence =
      workspace_.ReadConfidence("0.png").values;
  ASSERT_EQ(confidence.size(), static_cast<size_t>(kNumPixels));
  const float nothing_known = confidence[kHeight / 2 * kWidth];
  EXPECT_GT(nothing_known, 0);
  EXPECT_GT(confidence[kConfirmedPixel], nothing_known + 0.1f);
  EXPECT_GT(confidence[kUnconfirmedPixel], nothing_known + 0.1f);
}

TEST_F(AverageMapsTest, MemoryDoesNotChangeTheResult) {
  options_.max_bytes = 1;
  Average();
  for (int v = 0; v < 3; ++v) {
    EXPECT_NEAR(Read(v, MapType::kGeometric).depth[kConfirmedPixel],
                (9.9 + 10.1 + 10.2) / 3,
                1e-4);
  }
}

TEST_F(AverageMapsTest, TellsWhichFileIsMissing) {
  const std::string path =
      workspace_.DepthMapPath("1.png", MapType::kGeometric);
  std::filesystem::remove(path);
  try {
    Average();
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find(path), std::string::npos);
  }
}

}  // namespace
}  // namespace structnerf
