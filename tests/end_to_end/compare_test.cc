// structnerf_compare on a tiny scene: a workspace of ours against one as
// PatchMatch leaves it.

#include "tests/colmap_plugin/tiny_model.h"
#include "tests/end_to_end/json_files.h"
#include "tests/end_to_end/run_program.h"
#include "tests/support/temp_dir.h"

#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

namespace structnerf {
namespace {

namespace fs = std::filesystem;

using testing::HasSubstr;
using testing::Not;

class CompareTest : public testing::Test {
 protected:
  CompareTest() {
    const TinyModel model = MakeTinyModel(3);
    model.WriteImages(temp_dir_ / "images");
    model.WriteModel(temp_dir_ / "sparse");
    fs::create_directories(temp_dir_ / "depth");
    for (const TinyModel::Image& image : model.images) {
      cv::imwrite(temp_dir_ / "depth/" + image.name,
                  cv::Mat(48, 64, CV_16UC1, cv::Scalar(4000)));
    }
  }

  std::string Ours() const { return temp_dir_ / "ours"; }
  std::string Other() const { return temp_dir_ / "other"; }
  std::string Page() const { return temp_dir_ / "page"; }

  TempDir temp_dir_;
};

TEST_F(CompareTest, NeedsNothingOfOursFromOneOfThem) {
  ASSERT_EQ(RunProgram({"structnerf_dense",
                        "--image_path",
                        temp_dir_ / "images",
                        "--input_path",
                        temp_dir_ / "sparse",
                        "--output_path",
                        Ours(),
                        "--StructNeRF.quality=low",
                        "--StructNeRF.num_steps=20"})
                .exit_code,
            0);
  fs::copy(Ours(), Other(), fs::copy_options::recursive);
  fs::remove_all(Other() + "/structnerf");
  fs::remove(Other() + "/fused.ply");

  const ProgramResult result = RunProgram({"structnerf_compare",
                                           Ours(),
                                           Other(),
                                           "--ground_truth_path",
                                           temp_dir_ / "depth",
                                           "--output_path",
                                           Page()});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  EXPECT_THAT(result.out, HasSubstr("100.0 % agree within 1 %"));
  EXPECT_THAT(result.out, HasSubstr("comparison.html"));
  const auto json = ReadJson(Page() + "/comparison.json");
  EXPECT_EQ(json["agreement"]["median_relative_difference"], 0);
  EXPECT_EQ(json["views"].size(), 3);
  const auto& ours = json["workspaces"][0];
  const auto& other = json["workspaces"][1];
  EXPECT_GT(ours["coverage"], 0);
  EXPECT_EQ(ours["coverage"], other["coverage"]);
  EXPECT_GT(ours["seconds"], 0);
  EXPECT_GT(ours["fused_points"], 0);
  EXPECT_TRUE(other["seconds"].is_null());
  EXPECT_TRUE(other["fused_points"].is_null());
  EXPECT_EQ(ours["evaluation"]["maps"], other["evaluation"]["maps"]);
  std::ifstream page(Page() + "/comparison.html");
  const std::string html(std::istreambuf_iterator<char>(page), {});
  EXPECT_THAT(html, HasSubstr("<h2>2.png</h2>"));
  EXPECT_THAT(html, Not(HasSubstr(": none")));
}

TEST_F(CompareTest, OneLineForBadInputAndNothingWritten) {
  const auto expect_error = [&](std::vector<std::string> arguments,
                                const std::string& message) {
    arguments.insert(arguments.begin(), "structnerf_compare");
    const ProgramResult result = RunProgram(arguments);
    EXPECT_EQ(result.exit_code, EXIT_FAILURE);
    EXPECT_THAT(result.error, HasSubstr("ERROR: "));
    EXPECT_THAT(result.error, HasSubstr(message));
    EXPECT_FALSE(fs::exists(Page()));
  };
  const std::string model_only = temp_dir_ / "";
  expect_error({}, "Two workspaces are needed");
  expect_error({model_only, temp_dir_ / "none", "--output_path", Page()},
               "does not exist");
  expect_error({model_only, model_only}, "--output_path is missing");
  std::ofstream(temp_dir_ / "file") << "no folder";
  expect_error({model_only, model_only, "--output_path", temp_dir_ / "file"},
               "that is no folder");
  expect_error({model_only, model_only, "--output_path", Page()},
               "has no depth maps; run patch_match_stereo");
}

}  // namespace
}  // namespace structnerf
