#include "colmap_plugin/dense_workspace.h"

#include "tests/support/file_size_limit.h"
#include "tests/support/temp_dir.h"
#include "tests/support/text_file.h"

#include <filesystem>
#include <fstream>

#include <colmap/mvs/consistency_graph.h>
#include <colmap/mvs/depth_map.h>
#include <colmap/mvs/normal_map.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace structnerf {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

// Width 3 and height 2, every value different.
StereoMaps MakeMaps() {
  StereoMaps maps{3, 2, {}, {}};
  for (int i = 0; i < 6; ++i) {
    maps.depth.push_back(0.5f + i);
  }
  for (int i = 0; i < 18; ++i) {
    maps.normal.push_back(-0.01f * i);
  }
  return maps;
}

template <typename Function>
std::string ErrorOf(Function function) {
  try {
    function();
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

class DenseWorkspaceTest : public testing::Test {
 protected:
  DenseWorkspaceTest() : workspace_(temp_dir_ / "dense") {}

  TempDir temp_dir_;
  DenseWorkspace workspace_;
};

TEST_F(DenseWorkspaceTest, ColmapReadsMaps) {
  workspace_.CreateFolders({"a.jpg"});
  const StereoMaps maps = MakeMaps();
  workspace_.WriteMaps("a.jpg", MapType::kGeometric, maps);

  colmap::mvs::DepthMap depth_map;
  depth_map.Read(temp_dir_ / "dense/stereo/depth_maps/a.jpg.geometric.bin");
  colmap::mvs::NormalMap normal_map;
  normal_map.Read(temp_dir_ / "dense/stereo/normal_maps/a.jpg.geometric.bin");
  ASSERT_EQ(depth_map.GetWidth(), 3);
  ASSERT_EQ(depth_map.GetHeight(), 2);
  ASSERT_EQ(normal_map.GetDepth(), 3);
  for (int row = 0; row < 2; ++row) {
    for (int col = 0; col < 3; ++col) {
      EXPECT_EQ(depth_map.Get(row, col), maps.depth[row * 3 + col]);
      for (int axis = 0; axis < 3; ++axis) {
        EXPECT_EQ(normal_map.Get(row, col, axis),
                  maps.normal[axis * 6 + row * 3 + col]);
      }
    }
  }
}

TEST_F(DenseWorkspaceTest, ColmapReadsConsistencyGraph) {
  workspace_.CreateFolders({"a.jpg"});
  workspace_.WriteConsistencyGraph("a.jpg", 3, 2, {2, 0, 2, 1, 4, 0, 1, 1, 3});

  colmap::mvs::ConsistencyGraph graph;
  graph.Read(temp_dir_ / "dense/stereo/consistency_graphs/a.jpg.geometric.bin");
  int num_images = 0;
  const int* image_idxs = nullptr;
  graph.GetImageIdxs(/*row=*/0, /*col=*/2, &num_images, &image_idxs);
  EXPECT_THAT(std::vector<int>(image_idxs, image_idxs + num_images),
              ElementsAre(1, 4));
  graph.GetImageIdxs(/*row=*/1, /*col=*/0, &num_images, &image_idxs);
  EXPECT_THAT(std::vector<int>(image_idxs, image_idxs + num_images),
              ElementsAre(3));
  graph.GetImageIdxs(/*row=*/1, /*col=*/2, &num_images, &image_idxs);
  EXPECT_EQ(num_images, 0);
}

TEST_F(DenseWorkspaceTest, EmptyConsistencyGraphHasItsSize) {
  workspace_.CreateFolders({"a.jpg"});
  workspace_.WriteConsistencyGraph("a.jpg", 3, 2, {});
  EXPECT_EQ(ReadText(workspace_.ConsistencyGraphPath("a.jpg")), "3&2&1&");
}

TEST_F(DenseWorkspaceTest, ReadsBackWhatItWrote) {
  workspace_.CreateFolders({"left/a.jpg", "right/deep/a.jpg"});
  const StereoMaps maps = MakeMaps();
  workspace_.WriteMaps("right/deep/a.jpg", MapType::kPhotometric, maps);
  const StereoMaps read =
      workspace_.ReadMaps("right/deep/a.jpg", MapType::kPhotometric);
  EXPECT_EQ(read.width, 3);
  EXPECT_EQ(read.height, 2);
  EXPECT_EQ(read.depth, maps.depth);
  EXPECT_EQ(read.normal, maps.normal);
  EXPECT_TRUE(std::filesystem::exists(
      temp_dir_ / "dense/stereo/depth_maps/right/deep/a.jpg.photometric.bin"));
}

TEST_F(DenseWorkspaceTest, NamesDamagedMap) {
  workspace_.CreateFolders({"a.jpg"});
  workspace_.WriteMaps("a.jpg", MapType::kPhotometric, MakeMaps());
  const std::string path =
      workspace_.NormalMapPath("a.jpg", MapType::kPhotometric);
  std::filesystem::resize_file(path, std::filesystem::file_size(path) - 1);
  const auto read = [&]() {
    workspace_.ReadMaps("a.jpg", MapType::kPhotometric);
  };
  EXPECT_THAT(ErrorOf(read), HasSubstr(path));
  for (const char* header : {"100000000&100000000&3&",
                             "-1&-1&3&abcdabcdabcd",
                             "0&0&3&",
                             "1,1&3&abcdabcdabcd"}) {
    std::ofstream(path) << header;
    EXPECT_THAT(ErrorOf(read), HasSubstr(path));
  }
  // Sound by itself, but of another size than the other map.
  std::ofstream(path) << "1&1&3&abcdabcdabcd";
  EXPECT_THAT(ErrorOf(read), HasSubstr("different sizes"));
  std::filesystem::remove(path);
  EXPECT_THAT(ErrorOf(read), HasSubstr(path));
}

TEST_F(DenseWorkspaceTest, FullDiskLeavesNoHalfFile) {
  workspace_.CreateFolders({"a.jpg"});
  StereoMaps maps{100, 100, {}, {}};
  maps.depth.resize(10000);
  maps.normal.resize(30000);
  std::string error;
  {
    const ScopedFileSizeLimit limit(20000);
    error = ErrorOf(
        [&]() { workspace_.WriteMaps("a.jpg", MapType::kPhotometric, maps); });
  }
  EXPECT_THAT(error, HasSubstr("a.jpg.photometric.bin"));
  EXPECT_THAT(error, HasSubstr("disk full"));
  EXPECT_TRUE(std::filesystem::is_empty(temp_dir_ / "dense/stereo/depth_maps"));
}

TEST_F(DenseWorkspaceTest, FindsExistingResults) {
  workspace_.CreateFolders({"a.jpg", "b.jpg"});
  EXPECT_THAT(workspace_.FindResults({"a.jpg", "b.jpg"}, 10), IsEmpty());
  workspace_.WriteMaps("b.jpg", MapType::kGeometric, MakeMaps());
  EXPECT_THAT(
      workspace_.FindResults({"a.jpg", "b.jpg"}, 10),
      ElementsAre(workspace_.DepthMapPath("b.jpg", MapType::kGeometric),
                  workspace_.NormalMapPath("b.jpg", MapType::kGeometric)));
  EXPECT_EQ(workspace_.FindResults({"b.jpg"}, 1).size(), 1);
}

TEST_F(DenseWorkspaceTest, ConfigsListSourcesByName) {
  workspace_.CreateFolders({"a.jpg"});
  workspace_.WriteConfigs({"a.jpg", "sub/b.jpg", "c.jpg"}, {{2, 1}, {0}, {}});
  EXPECT_EQ(ReadText(temp_dir_ / "dense/stereo/patch-match.cfg"),
            "a.jpg\nc.jpg, sub/b.jpg\n"
            "sub/b.jpg\na.jpg\n"
            "c.jpg\n__auto__, 20\n");
  EXPECT_EQ(ReadText(temp_dir_ / "dense/stereo/fusion.cfg"),
            "a.jpg\nsub/b.jpg\nc.jpg\n");
}

TEST_F(DenseWorkspaceTest, ConfigsOfAnotherWorkspaceAreTaken) {
  workspace_.CreateFolders({"a.jpg"});
  workspace_.WriteConfigs({"a.jpg", "b.jpg"}, {{1}, {0}});
  const DenseWorkspace other(temp_dir_ / "other");
  workspace_.CopyConfigsOf(other);
  EXPECT_EQ(ReadText(temp_dir_ / "dense/stereo/fusion.cfg"), "a.jpg\nb.jpg\n");
  std::filesystem::create_directories(temp_dir_ / "other/stereo");
  std::ofstream(temp_dir_ / "other/stereo/fusion.cfg") << "a.jpg";
  workspace_.CopyConfigsOf(other);
  EXPECT_EQ(ReadText(temp_dir_ / "dense/stereo/fusion.cfg"), "a.jpg");
  EXPECT_EQ(ReadText(temp_dir_ / "dense/stereo/patch-match.cfg"),
            "a.jpg\nb.jpg\nb.jpg\na.jpg\n");
}

TEST_F(DenseWorkspaceTest, CommaInNameLeavesSourcesToColmap) {
  workspace_.CreateFolders({"a.jpg"});
  workspace_.WriteConfigs({"a,1.jpg", "b.jpg"}, {{1}, {0}});
  EXPECT_EQ(ReadText(temp_dir_ / "dense/stereo/patch-match.cfg"),
            "a,1.jpg\n__auto__, 20\nb.jpg\n__auto__, 20\n");
}

}  // namespace
}  // namespace structnerf
