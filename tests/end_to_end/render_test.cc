// New views of a trained field, as a user calls for them.

#include "colmap_plugin/staged_folder.h"
#include "nerf/util/median.h"
#include "tests/end_to_end/room_run.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

namespace structnerf {
namespace {

namespace fs = std::filesystem;

using testing::HasSubstr;

constexpr int kNumViews = 6;

// A short run on a small room.
class RenderTest : public RoomRunTest {
 protected:
  static void SetUpTestSuite() {
    SyntheticRoomOptions options;
    options.num_views = kNumViews;
    options.width = 120;
    options.height = 90;
    RunOnRoom(options);
  }

  static ProgramResult Render(const std::string& output_name,
                              std::vector<std::string> arguments,
                              const std::string& workspace_path = Dense()) {
    arguments.insert(arguments.begin(),
                     {"structnerf_render",
                      "--workspace_path",
                      workspace_path,
                      "--output_path",
                      *temp_dir_ / output_name});
    return RunProgram(arguments);
  }

  // Median over pixels of |a / b - 1| of two 16-bit depth images.
  static double MedianDifference(const std::string& a, const std::string& b) {
    const cv::Mat1w image_a = cv::imread(a, cv::IMREAD_UNCHANGED);
    const cv::Mat1w image_b = cv::imread(b, cv::IMREAD_UNCHANGED);
    EXPECT_FALSE(image_a.empty()) << a;
    if (image_a.empty() || image_a.size() != image_b.size()) {
      return std::numeric_limits<double>::infinity();
    }
    std::vector<double> differences;
    std::transform(
        image_a.begin(),
        image_a.end(),
        image_b.begin(),
        std::back_inserter(differences),
        [](const double x, const double y) { return std::abs(x / y - 1); });
    return Median(&differences);
  }
};

TEST_F(RenderTest, AtTheInputPosesItShowsThePhotographs) {
  // As many frames as views are the views.
  const ProgramResult result =
      Render("input", {"--num_frames", std::to_string(kNumViews)});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  for (int i = 0; i < kNumViews; ++i) {
    const std::string name = "/frame_000" + std::to_string(i) + ".png";
    const cv::Mat color = cv::imread(*temp_dir_ / "input/color" + name);
    const cv::Mat photograph = cv::imread(Room() + "/images" + name);
    ASSERT_EQ(color.size(), photograph.size());
    EXPECT_GT(cv::PSNR(color, photograph), 16) << name;
    EXPECT_LT(MedianDifference(*temp_dir_ / "input/depth" + name,
                               Room() + "/depth" + name),
              0.1)
        << name;
    for (const char* kind : {"normal", "depth_color"}) {
      EXPECT_EQ(cv::imread(*temp_dir_ / "input/" + kind + name).size(),
                photograph.size());
    }
  }
}

TEST_F(RenderTest, OrbitsAndTakesPoses) {
  ProgramResult result = Render(
      "orbit", {"--path=orbit", "--num_frames=3", "--max_image_size=60"});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  EXPECT_EQ(cv::imread(*temp_dir_ / "orbit/color/frame_0002.png").size(),
            cv::Size(60, 45));
  EXPECT_FALSE(fs::exists(*temp_dir_ / "orbit/color/frame_0003.png"));

  // The workspace's own model as poses gives its photographs.
  result = Render("model", {"--poses_path", Dense() + "/sparse"});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  EXPECT_LT(MedianDifference(*temp_dir_ / "model/depth/frame_0002.png.png",
                             Room() + "/depth/frame_0002.png"),
            0.1);

  std::ofstream(*temp_dir_ / "poses.txt") << "mine 1 0 0 0 0 0 0\n";
  result = Render("poses", {"--poses_path", *temp_dir_ / "poses.txt"});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  EXPECT_TRUE(fs::exists(*temp_dir_ / "poses/normal/mine.png"));
}

TEST_F(RenderTest, SaysWhichCamerasAreOutside) {
  std::ofstream(*temp_dir_ / "far.txt")
      << "far 1 0 0 0 0 0 1000\nhere 1 0 0 0 0 0 0\n";
  const ProgramResult result =
      Render("far", {"--poses_path", *temp_dir_ / "far.txt"});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  EXPECT_THAT(result.error, HasSubstr("of 2 cameras are outside"));
}

TEST_F(RenderTest, OneLineForBadInputAndNothingWritten) {
  const auto expect_error = [](const std::vector<std::string>& arguments,
                               const std::string& message,
                               const std::string& workspace_path = Dense()) {
    const ProgramResult result = Render("bad", arguments, workspace_path);
    EXPECT_EQ(result.exit_code, EXIT_FAILURE);
    EXPECT_THAT(result.error, HasSubstr("ERROR: "));
    EXPECT_THAT(result.error, HasSubstr(message));
    EXPECT_FALSE(fs::exists(*temp_dir_ / "bad"));
  };
  expect_error({"--path=spiral"}, "--path must be input or orbit");
  expect_error({"--num_frames=1"}, "--num_frames must be from 2 to 9999");
  expect_error({"--depth_scale=1e6"}, "pass for instance --depth_scale 1000.");
  expect_error({"--depth_scale=1"}, "pass for instance --depth_scale 1000.");
  expect_error({"--poses_path", *temp_dir_ / "none"}, "--poses_path");
  std::ofstream(*temp_dir_ / "escape.txt") << "../out 1 0 0 0 0 0 0\n";
  expect_error({"--poses_path", *temp_dir_ / "escape.txt"},
               "outside of --output_path");
  expect_error({}, "no trained field", Room());
  expect_error({}, "does not exist", *temp_dir_ / "nowhere");
}

TEST_F(RenderTest, KeepsARunThatCanBeGoneOnWith) {
  const std::string output_path = *temp_dir_ / "interrupted";
  const std::string checkpoint =
      StagedFolder::NotesPathOf(output_path) + "/checkpoint.bin";
  fs::create_directories(fs::path(checkpoint).parent_path());
  std::ofstream(checkpoint) << "half";
  EXPECT_THAT(Render("interrupted", {"--num_frames", "2"}).error,
              HasSubstr(output_path + " holds a run of structnerf_dense"));
  EXPECT_TRUE(fs::exists(checkpoint));
}

TEST_F(RenderTest, KeepsFramesUnlessTold) {
  fs::create_directories(*temp_dir_ / "kept/color");
  std::ofstream(*temp_dir_ / "kept/color/frame_0000.png") << "mine";
  const std::vector<std::string> arguments = {"--num_frames=2",
                                              "--max_image_size=30"};
  EXPECT_THAT(Render("kept", arguments).error, HasSubstr("in color already"));
  EXPECT_EQ(fs::file_size(*temp_dir_ / "kept/color/frame_0000.png"), 4);
  // Ground truth may lie in a folder of that name.
  fs::create_directories(*temp_dir_ / "scene/depth");
  EXPECT_THAT(Render("scene", arguments).error, HasSubstr("in depth already"));
  std::vector<std::string> replacing = arguments;
  replacing.push_back("--overwrite");
  EXPECT_EQ(Render("kept", replacing).exit_code, 0);
  EXPECT_EQ(cv::imread(*temp_dir_ / "kept/color/frame_0000.png").cols, 30);
}

}  // namespace
}  // namespace structnerf
