#include "colmap_plugin/depth_priors.h"

#include "colmap_plugin/dense_workspace.h"
#include "tests/support/temp_dir.h"

#include <filesystem>
#include <fstream>
#include <limits>
#include <stdexcept>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace structnerf {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

// Two views of 8 x 6 that are trained on at half that size.
class DepthPriorsTest : public testing::Test {
 protected:
  DepthPriorsTest() : workspace_(temp_dir_ / "dense") {
    for (const char* const name : {"a.png", "sub/b.png"}) {
      View& view = scene_.views.emplace_back();
      view.name = name;
      view.camera = {8, 6, 10, 10, 4, 3};
      view.image = {4, 3, std::vector<uint8_t>(3 * 4 * 3, 0)};
    }
    workspace_.CreateFolders({"a.png", "sub/b.png"});
  }

  // A map whose pixel (col, row) is 1 + col + 100 * row.
  void Write(const std::string& name,
             const int width,
             const int height,
             const MapType type = MapType::kGeometric) {
    StereoMaps maps{width, height, {}, {}};
    for (int row = 0; row < height; ++row) {
      for (int col = 0; col < width; ++col) {
        maps.depth.push_back(1.0f + col + 100 * row);
      }
    }
    maps.normal.assign(3 * maps.depth.size(), 0);
    workspace_.WriteMaps(name, type, maps);
  }

  std::vector<std::string> Load(const std::string& type = "geometric") {
    return LoadDepthPriors(
        temp_dir_ / "dense/stereo/depth_maps", type, &scene_);
  }

  std::string ErrorOf(const std::string& type = "geometric") {
    try {
      Load(type);
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "";
  }

  TempDir temp_dir_;
  DenseWorkspace workspace_;
  Scene scene_;
};

// The centre of the reduced pixel (col, row) is at (2 col + 1, 2 row + 1) of
// the camera, where the map has its pixel of this number.
TEST_F(DepthPriorsTest, TakesTheNearestPixel) {
  Write("a.png", 8, 6);
  Write("sub/b.png", 8, 6);
  EXPECT_THAT(Load(), IsEmpty());
  for (const View& view : scene_.views) {
    ASSERT_EQ(view.prior_depth.size(), 12u);
    for (int row = 0; row < 3; ++row) {
      for (int col = 0; col < 4; ++col) {
        EXPECT_EQ(view.prior_depth[row * 4 + col],
                  1 + (2 * col + 1) + 100 * (2 * row + 1));
      }
    }
    EXPECT_THAT(view.prior_deviation, IsEmpty());
  }
}

TEST_F(DepthPriorsTest, MapsOfReducedImagesAreStretched) {
  Write("a.png", 4, 3);
  Write("sub/b.png", 16, 12);
  Load();
  // At (0.5, 0.5) of the map, rounded up, and at (6, 6).
  EXPECT_EQ(scene_.views[0].prior_depth[0], 1 + 1 + 100);
  EXPECT_EQ(scene_.views[1].prior_depth[5], 1 + 6 + 600);
}

TEST_F(DepthPriorsTest, ViewsWithoutMapAreNamed) {
  Write("a.png", 8, 6);
  EXPECT_THAT(Load(), ElementsAre("sub/b.png"));
  EXPECT_THAT(scene_.views[1].prior_depth, IsEmpty());
  EXPECT_NO_THROW(scene_.views[0].prior_depth.at(11));
}

TEST_F(DepthPriorsTest, TypesAreApart) {
  Write("a.png", 8, 6, MapType::kPhotometric);
  EXPECT_THAT(ErrorOf(), HasSubstr("prior_type"));
  EXPECT_EQ(ErrorOf("photometric"), "");
}

TEST_F(DepthPriorsTest, PixelsWithoutDepthHaveNoPrior) {
  StereoMaps maps{8, 6, std::vector<float>(48, 2), std::vector<float>(144, 0)};
  maps.depth[9] = -1;
  maps.depth[11] = std::numeric_limits<float>::quiet_NaN();
  maps.depth[13] = std::numeric_limits<float>::infinity();
  workspace_.WriteMaps("a.png", MapType::kGeometric, maps);
  Load();
  EXPECT_EQ(scene_.views[0].prior_depth[0], 0);
  EXPECT_EQ(scene_.views[0].prior_depth[1], 0);
  EXPECT_EQ(scene_.views[0].prior_depth[2], 0);
  EXPECT_EQ(scene_.views[0].prior_depth[3], 2);
}

TEST_F(DepthPriorsTest, OtherShapesAndDamagedFilesAreRefused) {
  Write("sub/b.png", 8, 8);
  EXPECT_THAT(ErrorOf(), HasSubstr("b.png.geometric.bin is 8x8"));
  Write("sub/b.png", 8, 6);
  const std::string path =
      workspace_.DepthMapPath("sub/b.png", MapType::kGeometric);
  std::filesystem::resize_file(path, 100);
  EXPECT_THAT(ErrorOf(), HasSubstr(path));
  std::filesystem::remove(path);
  EXPECT_THAT(ErrorOf(), HasSubstr("dense/stereo/depth_maps"));
}

TEST_F(DepthPriorsTest, PathsAreFoldersOrModules) {
  Write("a.png", 8, 6);
  Progress progress;
  const std::vector<std::string> sentences = LoadPriors(
      temp_dir_ / "dense/stereo/depth_maps", "geometric", &progress, &scene_);
  ASSERT_EQ(sentences.size(), 1u);
  EXPECT_THAT(sentences[0], HasSubstr("sub/b.png"));

  const auto error_of = [&](const std::string& path) {
    try {
      LoadPriors(path, "geometric", &progress, &scene_);
    } catch (const std::runtime_error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_THAT(error_of(temp_dir_ / "none"), HasSubstr("neither a folder"));
  std::ofstream(temp_dir_ / "text.pt") << "text";
  EXPECT_THAT(error_of(temp_dir_ / "text.pt"), HasSubstr("TorchScript"));
}

}  // namespace
}  // namespace structnerf
