// Evaluation of a workspace as a user calls it.

#include "tests/end_to_end/json_files.h"
#include "tests/end_to_end/room_run.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <torch/script.h>

namespace structnerf {
namespace {

namespace fs = std::filesystem;

using testing::HasSubstr;
using testing::Not;
using testing::UnorderedElementsAre;

// A short run on a small room that keeps every fourth view out.
class EvalTest : public RoomRunTest {
 protected:
  static void SetUpTestSuite() {
    SyntheticRoomOptions options;
    options.num_views = 8;
    options.width = 160;
    options.height = 120;
    options.camera_models = {"OPENCV"};
    RunOnRoom(options, {"--StructNeRF.test_every=4"});
  }

  static std::vector<std::string> Arguments(const std::string& output_path) {
    return {"structnerf_eval",
            "--workspace_path",
            Dense(),
            "--ground_truth_path",
            Room() + "/depth",
            "--image_path",
            Room() + "/images",
            "--input_path",
            Room() + "/sparse/0",
            "--output_path",
            output_path};
  }
};

TEST_F(EvalTest, MeasuresDepthCloudAndHeldOutImages) {
  const std::string path = *temp_dir_ / "eval.json";
  const auto before = ReadFolder(Dense());
  const ProgramResult result = RunProgram(Arguments(path));
  ASSERT_EQ(result.exit_code, 0) << result.error;
  EXPECT_EQ(ReadFolder(Dense()), before);
  EXPECT_THAT(result.out, HasSubstr("Depth maps (photometric): 8 images"));
  EXPECT_THAT(result.out, HasSubstr("LPIPS was not measured"));

  const nlohmann::json json = ReadJson(path);
  EXPECT_NEAR(json["scale"]["metres_per_unit"], 1, 0.02);
  const auto& photometric = json["maps"]["photometric"]["sfm_scale"]["all"];
  const auto& geometric = json["maps"]["geometric"]["sfm_scale"]["all"];
  EXPECT_GT(photometric["completeness"], 0.8);
  EXPECT_GT(photometric["within_10cm"], 0.3);
  EXPECT_LT(photometric["median_abs_m"], 0.2);
  EXPECT_LT(geometric["completeness"], photometric["completeness"]);
  EXPECT_LT(geometric["median_abs_m"], photometric["median_abs_m"]);
  EXPECT_GT(json["cloud"]["precision_10cm"], 0.3);
  EXPECT_GT(json["maps"]["photometric"]["planes"]["planes"], 3);

  const auto& held_out = json["held_out"];
  ASSERT_EQ(held_out["per_image"].size(), 2);
  EXPECT_GT(held_out["psnr"], 14);
  EXPECT_GT(held_out["ssim"], 0.3);
  EXPECT_LT(held_out["ssim"], 1);
  EXPECT_TRUE(held_out["lpips"].is_null());
  EXPECT_EQ(held_out["depth"]["images"], 2);
  EXPECT_EQ(held_out["depth"]["image_scale"]["all"]["completeness"],
            held_out["depth"]["predictions_scale"]["all"]["completeness"]);
  // Training measured the same images, reduced.
  const double training_psnr = ReadReport(Dense())["training"]["held_out_psnr"];
  EXPECT_NEAR(held_out["psnr"], training_psnr, 2.5);
}

TEST_F(EvalTest, MeasuresWhatAModuleSays) {
  torch::jit::Module module("distance");
  module.define("def forward(self, a, b):\n  return (a - b).abs().mean()\n");
  module.save(*temp_dir_ / "distance.pt");
  const std::string path = *temp_dir_ / "lpips.json";
  std::vector<std::string> arguments = Arguments(path);
  arguments.insert(arguments.end(),
                   {"--lpips_path", *temp_dir_ / "distance.pt"});
  const ProgramResult result = RunProgram(arguments);
  ASSERT_EQ(result.exit_code, 0) << result.error;
  EXPECT_THAT(result.out, Not(HasSubstr("LPIPS was not measured")));
  const nlohmann::json json = ReadJson(path);
  const auto& held_out = json["held_out"];
  // Colours are in [-1, 1] there, so that errors count twice.
  const double psnr = held_out["psnr"];
  const double root_mean_square = 2 * std::pow(10, -psnr / 20);
  EXPECT_GT(held_out["lpips"], 0.2 * root_mean_square);
  EXPECT_LT(held_out["lpips"], 1.5 * root_mean_square);
}

TEST_F(EvalTest, ImagesThatTheModelNeverSawAreMatchedByTheirPoses) {
  // A model of the first six images only, trained on all of them.
  const std::string strict = *temp_dir_ / "strict";
  const std::string sparse = *temp_dir_ / "sparse";
  std::ofstream(*temp_dir_ / "left_out.txt")
      << "frame_0006.png\nframe_0007.png\n";
  fs::create_directories(sparse);
  ASSERT_EQ(RunProgram({"image_deleter",
                        "--input_path",
                        Room() + "/sparse/0",
                        "--output_path",
                        sparse,
                        "--image_names_path",
                        *temp_dir_ / "left_out.txt"})
                .exit_code,
            0);
  const ProgramResult trained = RunProgram({"structnerf_dense",
                                            "--image_path",
                                            Room() + "/images",
                                            "--input_path",
                                            sparse,
                                            "--output_path",
                                            strict,
                                            "--StructNeRF.quality=low",
                                            "--StructNeRF.num_steps=200"});
  ASSERT_EQ(trained.exit_code, 0) << trained.error;
  const std::string path = *temp_dir_ / "strict.json";
  std::vector<std::string> arguments = Arguments(path);
  arguments[2] = strict;
  arguments.insert(arguments.end(), {"--test_workspace_path", Dense()});
  const ProgramResult result = RunProgram(arguments);
  ASSERT_EQ(result.exit_code, 0) << result.error;
  const nlohmann::json json = ReadJson(path);
  const auto& held_out = json["held_out"];
  EXPECT_EQ(held_out["seen_by_structure_from_motion"], false);
  ASSERT_EQ(held_out["per_image"].size(), 2);
  EXPECT_THAT((std::vector<std::string>{held_out["per_image"][0]["name"],
                                        held_out["per_image"][1]["name"]}),
              UnorderedElementsAre("frame_0006.png", "frame_0007.png"));
  EXPECT_LT(held_out["alignment"]["relative_error"], 1e-6);
  EXPECT_GT(held_out["psnr"], 10);
  EXPECT_EQ(held_out["depth"]["images"], 2);
}

TEST_F(EvalTest, OneLineForBadInput) {
  std::vector<std::string> arguments = Arguments(*temp_dir_ / "bad.json");
  arguments.insert(arguments.end(), {"--depth_scale", "1"});
  const ProgramResult scale = RunProgram(arguments);
  EXPECT_EQ(scale.exit_code, EXIT_FAILURE);
  EXPECT_THAT(scale.error, HasSubstr("ERROR: "));
  EXPECT_THAT(scale.error, HasSubstr("--depth_scale"));
  EXPECT_FALSE(fs::exists(*temp_dir_ / "bad.json"));

  const ProgramResult nothing = RunProgram({"structnerf_eval"});
  EXPECT_EQ(nothing.exit_code, EXIT_FAILURE);
  EXPECT_THAT(nothing.error, HasSubstr("--workspace_path is missing"));

  std::ofstream(Dense() + "/../module.pt") << "no module";
  arguments = Arguments(*temp_dir_ / "bad.json");
  arguments.insert(arguments.end(), {"--lpips_path", *temp_dir_ / "module.pt"});
  const ProgramResult module = RunProgram(arguments);
  EXPECT_EQ(module.exit_code, EXIT_FAILURE);
  EXPECT_THAT(module.error, HasSubstr("module.pt is not a TorchScript module"));
  EXPECT_THAT(module.error, Not(HasSubstr("terminate")));
}

}  // namespace
}  // namespace structnerf
