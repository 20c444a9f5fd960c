// structnerf_tradeoff on a tiny scene.

#include "tests/colmap_plugin/tiny_model.h"
#include "tests/end_to_end/json_files.h"
#include "tests/end_to_end/run_program.h"
#include "tests/support/temp_dir.h"

#include <filesystem>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

namespace structnerf {
namespace {

namespace fs = std::filesystem;

using testing::HasSubstr;

class TradeoffTest : public testing::Test {
 protected:
  TradeoffTest() {
    TinyModel model = MakeTinyModel(3);
    model.WriteImages(temp_dir_ / "images");
    model.WriteModel(temp_dir_ / "sparse");
  }

  ProgramResult Run(const std::string& settings,
                    const std::vector<std::string>& more_arguments = {}) const {
    std::vector<std::string> arguments = {"structnerf_tradeoff",
                                          "--image_path",
                                          temp_dir_ / "images",
                                          "--input_path",
                                          temp_dir_ / "sparse",
                                          "--output_path",
                                          temp_dir_ / "tradeoff",
                                          "--num_seeds=2",
                                          "--settings",
                                          settings};
    arguments.insert(
        arguments.end(), more_arguments.begin(), more_arguments.end());
    return RunProgram(arguments);
  }

  TempDir temp_dir_;
};

TEST_F(TradeoffTest, MeasuresEverySettingOnce) {
  const std::string settings =
      "quality=low num_steps=20, quality=low num_steps=60";
  const ProgramResult result = Run(settings);
  ASSERT_EQ(result.exit_code, 0) << result.error;
  EXPECT_THAT(result.out, HasSubstr("num_steps=60, seed 1: "));
  EXPECT_THAT(result.out, HasSubstr("Take quality=low num_steps="));
  const auto object = ReadJson(temp_dir_ / "tradeoff/tradeoff.json");
  EXPECT_EQ(object["error"],
            "pixels of held-out photographs predicted wrongly, %");
  ASSERT_EQ(object["settings"].size(), 2u);
  for (const auto& setting : object["settings"]) {
    ASSERT_EQ(setting["runs"].size(), 2u);
    for (const auto& run : setting["runs"]) {
      EXPECT_GT(run["seconds"], 0);
      EXPECT_GT(run["peak_bytes"], 1 << 20);
      EXPECT_GE(run["error"], 0);
      EXPECT_LE(run["error"], 1);
    }
  }
  // Only what was measured stays.
  const fs::path run = temp_dir_ / "tradeoff/runs/quality=low+num_steps=20";
  EXPECT_TRUE(fs::exists(run / "seed1/measurement.json"));
  EXPECT_TRUE(fs::exists(run / "seed1/depth.png"));
  EXPECT_FALSE(fs::exists(run / "seed1/workspace"));

  // The same command again only reads, however its paths are written.
  const auto before = ReadFolder(temp_dir_ / "tradeoff/runs");
  const ProgramResult again = RunProgram({"structnerf_tradeoff",
                                          "--image_path",
                                          temp_dir_ / "sparse/../images/",
                                          "--input_path",
                                          temp_dir_ / "sparse/",
                                          "--output_path",
                                          temp_dir_ / "tradeoff",
                                          "--num_seeds=2",
                                          "--settings",
                                          settings});
  ASSERT_EQ(again.exit_code, 0) << again.error;
  EXPECT_EQ(ReadFolder(temp_dir_ / "tradeoff/runs"), before);
}

TEST_F(TradeoffTest, ARunThatFailsIsNamed) {
  const ProgramResult result =
      Run("quality=low num_steps=20, quality=low max_memory_gb=0.001");
  EXPECT_NE(result.exit_code, 0);
  EXPECT_THAT(result.error, HasSubstr("raise --StructNeRF.max_memory_gb"));
  EXPECT_THAT(result.error,
              HasSubstr("The run with quality=low max_memory_gb=0.001"));
  EXPECT_TRUE(fs::exists(
      temp_dir_ /
      "tradeoff/runs/quality=low+num_steps=20/seed0/measurement.json"));
}

TEST_F(TradeoffTest, WhatIsWrongIsSaidBeforeAnythingIsRun) {
  const auto expect_error = [&](const ProgramResult& result,
                                const std::string& text) {
    EXPECT_NE(result.exit_code, 0);
    EXPECT_THAT(result.error, HasSubstr(text));
    EXPECT_FALSE(fs::exists(temp_dir_ / "tradeoff"));
  };
  expect_error(Run("quality=low num_steps=20, quality=best"),
               "quality must be low");
  expect_error(Run("quality=low num_steps=20, num_stepz=3"), "num_stepz");
  expect_error(Run("quality=low num_steps=0"), "num_steps must be");
  fs::remove(temp_dir_ / "images/0.png");
  expect_error(Run("quality=low num_steps=20"), "0.png");
}

TEST_F(TradeoffTest, MissingPathsAreNamed) {
  const ProgramResult result =
      RunProgram({"structnerf_tradeoff", "--image_path", temp_dir_ / "images"});
  EXPECT_NE(result.exit_code, 0);
  EXPECT_THAT(result.error, HasSubstr("--input_path is missing"));
}

TEST_F(TradeoffTest, TruthIsLookedAtBeforeAnythingIsRun) {
  fs::create_directory(temp_dir_ / "truth");
  const auto expect_error = [&](const std::string& text) {
    const ProgramResult result =
        Run("quality=low num_steps=20",
            {"--ground_truth_path", temp_dir_ / "truth"});
    EXPECT_NE(result.exit_code, 0);
    EXPECT_THAT(result.error, HasSubstr(text));
    EXPECT_THAT(result.error, HasSubstr("--ground_truth_path"));
    EXPECT_FALSE(fs::exists(temp_dir_ / "tradeoff"));
  };
  expect_error("No image of the model has ground truth");
  // None of whose pixels has a value.
  cv::imwrite(temp_dir_ / "truth/0.png", cv::Mat1w(48, 64, uint16_t{0}));
  expect_error("no sparse point has ground truth");
}

}  // namespace
}  // namespace structnerf
