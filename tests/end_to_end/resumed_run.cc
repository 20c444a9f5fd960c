#include "tests/end_to_end/resumed_run.h"

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>

#include <opencv2/imgcodecs.hpp>

namespace structnerf {

namespace fs = std::filesystem;

ResumedRunTest::ResumedRunTest() : model_(MakeTinyModel(4)) {
  model_.cameras[0] = {"SIMPLE_RADIAL", 64, 48, {60, 32, 24, 0.1}};
  model_.WriteImages(temp_dir_ / "images");
  model_.WriteModel(temp_dir_ / "sparse");
  fs::create_directory(temp_dir_ / "masks");
  cv::Mat mask(48, 64, CV_8U, cv::Scalar(255));
  mask.rowRange(0, 10) = 0;
  cv::imwrite(temp_dir_ / "masks/1.png.png", mask);

  const auto begin = std::chrono::steady_clock::now();
  const ProgramResult result = RunProgram(Command({}, "expected"));
  seconds_ =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin)
          .count();
  EXPECT_EQ(result.exit_code, 0) << result.error;
  expected_ = ReadResult("expected");
  EXPECT_GT(expected_.at("stereo/depth_maps/1.png.geometric.bin").size(),
            1000u);
  EXPECT_GT(expected_.at("fused.ply").size(), 1000u);
}

ProgramOptions ResumedRunTest::Command(
    const std::vector<std::string>& more_arguments,
    const std::string& output) const {
  ProgramOptions options;
  options.arguments = {"structnerf_dense",
                       "--image_path",
                       temp_dir_ / "images",
                       "--input_path",
                       temp_dir_ / "sparse",
                       "--mask_path",
                       temp_dir_ / "masks",
                       "--output_path",
                       temp_dir_ / output,
                       "--StructNeRF.num_steps=200",
                       "--StructNeRF.rays_per_step=64",
                       "--StructNeRF.num_levels=2",
                       "--StructNeRF.max_resolution=64",
                       "--StructNeRF.log2_table_size=10",
                       "--StructNeRF.cache_resolution=16",
                       "--StructNeRF.max_relative_std=100",
                       "--StructNeRF.max_relative_depth_error=1",
                       "--StructNeRF.max_reprojection_error=100",
                       "--StereoFusion.max_reproj_error=100",
                       "--StereoFusion.max_depth_error=1",
                       "--StereoFusion.max_normal_error=180",
                       "--StereoFusion.num_threads=1",
                       // A hundredth of a second.
                       "--StructNeRF.checkpoint_minutes=0.00016"};
  for (const std::string& argument : more_arguments) {
    const std::string name = argument.substr(0, argument.find('=') + 1);
    const auto same = std::find_if(
        options.arguments.begin(),
        options.arguments.end(),
        [&](const std::string& other) { return other.rfind(name, 0) == 0; });
    if (same != options.arguments.end()) {
      *same = argument;
    } else {
      options.arguments.push_back(argument);
    }
  }
  return options;
}

ProgramResult ResumedRunTest::ExpectResult(const ProgramOptions& options,
                                           const std::string& output) const {
  const ProgramResult result = RunProgram(options);
  EXPECT_EQ(result.exit_code, 0) << result.error;
  const auto actual = ReadResult(output);
  for (const auto& [name, content] : expected_) {
    const auto found = actual.find(name);
    EXPECT_TRUE(found != actual.end() && found->second == content) << name;
  }
  EXPECT_EQ(actual.size(), expected_.size());
  return result;
}

std::map<std::string, std::string> ResumedRunTest::ReadResult(
    const std::string& output) const {
  auto contents = ReadFolder(temp_dir_ / output);
  contents.erase("structnerf/report.json");
  contents.erase("structnerf/report.txt");
  return contents;
}

void ResumedRunTest::Terminate() const {
  Program program(Command());
  while (!fs::exists(CheckpointPath())) {
    ASSERT_FALSE(program.WaitFor(0.001));
  }
  program.Signal(SIGTERM);
  ASSERT_EQ(program.Wait().exit_code, EXIT_FAILURE);
  ASSERT_TRUE(fs::exists(CheckpointPath()));
}

std::string ResumedRunTest::StagedPath() const {
  return temp_dir_ / "dense/.structnerf-partial";
}

std::string ResumedRunTest::CheckpointPath() const {
  return StagedPath() + "/.resume/checkpoint.bin";
}

}  // namespace structnerf
