#include "colmap_plugin/tradeoff/tradeoff_run.h"

#include "colmap_plugin/dense_workspace.h"
#include "colmap_plugin/json_text.h"
#include "colmap_plugin/text_output.h"
#include "tests/colmap_plugin/tiny_model.h"
#include "tests/support/file_size_limit.h"
#include "tests/support/temp_dir.h"

#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace structnerf {
namespace {

namespace fs = std::filesystem;

using testing::HasSubstr;

// A run that has ended, but has not been measured yet.
class TradeoffRunTest : public testing::Test {
 protected:
  TradeoffRunTest() {
    scene_.image_path = "images";
    scene_.input_path = "sparse";
    scene_.output_path = temp_dir_.Path().string();
    scene_.fingerprint = "0123";
    const DenseWorkspace workspace(Folder() + "/workspace");
    MakeTinyModel(1).WriteModel(workspace.SparsePath());
    workspace.CreateFolders({"0.png"});
    StereoMaps maps{64, 48, {}, std::vector<float>(3 * 64 * 48, 0.0f)};
    for (int i = 0; i < 64 * 48; ++i) {
      maps.depth.push_back(1.0f + i % 50);
    }
    workspace.WriteMaps("0.png", MapType::kPhotometric, maps);
    WriteTextFile(workspace.ReportFolder() + "/report.json", R"({
      "seconds": 20, "cpu_seconds": 38, "memory": {"peak_bytes": 5000},
      "training": {"stopped_early": false, "held_out_psnr": -1},
      "maps": {"pixels": 100, "geometric_pixels": 60}})");
    WriteTextFile(Folder() + "/run.json",
                  JsonText({{"images", "images"},
                            {"model", "sparse"},
                            {"masks", ""},
                            {"truth", ""},
                            {"truth_scale", 1000.0},
                            {"fingerprint", "0123"},
                            {"test_every", 0},
                            {"setting", "quality=low"}}));
  }

  std::string Folder() const {
    return temp_dir_ / ("runs/" + setting_.FolderName() + "/seed3");
  }

  TradeoffMeasurement Measure() const {
    return MeasureSetting(scene_, setting_, /*seed=*/3);
  }

  void ExpectRefused() const {
    try {
      Measure();
      ADD_FAILURE();
    } catch (const std::runtime_error& error) {
      EXPECT_THAT(error.what(), HasSubstr("choose another --output_path"));
    }
  }

  const TempDir temp_dir_;
  TradeoffScene scene_;
  const TradeoffSetting setting_ = {"quality=low", {}};
};

TEST_F(TradeoffRunTest, MeasuresOnce) {
  EXPECT_NEAR(Measure().error, 0.4, 1e-9);
  EXPECT_TRUE(fs::exists(TradeoffPicturePath(scene_, setting_, 3)));
  EXPECT_FALSE(fs::exists(Folder() + "/workspace"));
  EXPECT_NEAR(Measure().error, 0.4, 1e-9);
}

TEST_F(TradeoffRunTest, ARunOfAnotherSceneIsLeftAlone) {
  scene_.fingerprint = "4567";
  ExpectRefused();
  fs::remove(Folder() + "/run.json");
  ExpectRefused();
  EXPECT_TRUE(fs::exists(Folder() + "/workspace/structnerf/report.json"));
}

TEST_F(TradeoffRunTest, AMeasurementOfAnotherSceneIsLeftAlone) {
  Measure();
  EXPECT_FALSE(fs::exists(Folder() + "/run.json"));
  scene_.fingerprint = "4567";
  ExpectRefused();
  EXPECT_TRUE(fs::exists(Folder() + "/measurement.json"));
}

// Nothing counts as measured, and the run is kept for the next try.
TEST_F(TradeoffRunTest, APictureThatCannotBeWrittenIsNamed) {
  {
    const ScopedFileSizeLimit limit(50);
    try {
      Measure();
      ADD_FAILURE();
    } catch (const std::runtime_error& error) {
      EXPECT_THAT(error.what(), HasSubstr("depth.png could not be written"));
    }
  }
  EXPECT_FALSE(fs::exists(Folder() + "/measurement.json"));
  EXPECT_NEAR(Measure().error, 0.4, 1e-9);
}

}  // namespace
}  // namespace structnerf
