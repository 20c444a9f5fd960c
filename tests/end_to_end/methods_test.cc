// The paper's methods as a user calls them.

#include "tests/colmap_plugin/tiny_model.h"
#include "tests/end_to_end/json_files.h"
#include "tests/end_to_end/room_run.h"

#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <torch/script.h>

namespace structnerf {
namespace {

namespace fs = std::filesystem;

using testing::HasSubstr;
using testing::Not;

// Its first run makes the depth maps that others take as priors.
class MethodsTest : public RoomRunTest {
 protected:
  static void SetUpTestSuite() {
    SyntheticRoomOptions options;
    options.num_views = 6;
    options.width = 96;
    options.height = 72;
    RunOnRoom(options);
  }

  // Some steps with more arguments into this folder.
  static ProgramResult RunInto(const std::string& output_path,
                               const std::vector<std::string>& more_arguments) {
    std::vector<std::string> arguments = {"structnerf_dense",
                                          "--image_path",
                                          Room() + "/images",
                                          "--input_path",
                                          Room() + "/sparse/0",
                                          "--output_path",
                                          output_path,
                                          "--StructNeRF.quality=low",
                                          "--StructNeRF.num_steps=60"};
    arguments.insert(
        arguments.end(), more_arguments.begin(), more_arguments.end());
    return RunProgram(arguments);
  }
};

TEST_F(MethodsTest, PriorsOfAFolder) {
  const std::string priors = *temp_dir_ / "priors";
  fs::copy(Dense() + "/stereo/depth_maps", priors);
  ASSERT_TRUE(fs::remove(priors + "/frame_0002.png.geometric.bin"));
  for (const std::string method : {"dense_depth_prior", "nerfing_mvs"}) {
    const std::string output_path = *temp_dir_ / method;
    const ProgramResult result = RunInto(
        output_path,
        {"--StructNeRF.method=" + method, "--StructNeRF.prior_path=" + priors});
    ASSERT_EQ(result.exit_code, 0) << result.error;
    EXPECT_THAT(result.error,
                HasSubstr("image frame_0002.png has no geometric depth map"));
    EXPECT_THAT(result.error, Not(HasSubstr("frame_0001.png")));
    const nlohmann::json training = ReadReport(output_path)["training"];
    EXPECT_EQ(training["guards"]["view_without_prior"], 1);
    EXPECT_EQ(training["guards"].contains("inverted_ray_bounds"),
              method == "nerfing_mvs");
  }
}

TEST_F(MethodsTest, PriorsOfAModule) {
  // Three metres everywhere, give or take one.
  torch::jit::Module module("prior");
  module.define(
      "def forward(self, image, sparse_depth):\n"
      "  ones = 1.0 + 0.0 * sparse_depth\n"
      "  return (3.0 * ones, ones)\n");
  const std::string path = *temp_dir_ / "prior.pt";
  module.save(path);
  const std::string output_path = *temp_dir_ / "module";
  const ProgramResult result = RunInto(output_path,
                                       {"--StructNeRF.method=dense_depth_prior",
                                        "--StructNeRF.prior_path=" + path});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  EXPECT_EQ(ReadReport(output_path)["training"]["guards"]["view_without_prior"],
            0);
}

// Networks of full size, for as few rays and samples as will do.
TEST_F(MethodsTest, ThePaperItself) {
  const TinyModel model = [] {
    TinyModel tiny = MakeTinyModel(3);
    tiny.cameras[0] = {"PINHOLE", 32, 24, {30, 30, 16, 12}};
    return tiny;
  }();
  const std::string folder = *temp_dir_ / "tiny";
  fs::create_directories(folder + "/sparse");
  model.WriteModel(folder + "/sparse");
  model.WriteImages(folder + "/images");
  const std::string dense = folder + "/dense";
  const ProgramResult trained = RunProgram({"structnerf_dense",
                                            "--image_path",
                                            folder + "/images",
                                            "--input_path",
                                            folder + "/sparse",
                                            "--output_path",
                                            dense,
                                            "--StructNeRF.quality=paper",
                                            "--StructNeRF.num_steps=2",
                                            "--StructNeRF.rays_per_step=32",
                                            "--StructNeRF.num_samples=8",
                                            "--StructNeRF.num_fine_samples=8",
                                            "--StructNeRF.latent_size=48"});
  ASSERT_EQ(trained.exit_code, 0) << trained.error;
  const nlohmann::json report = ReadReport(dense);
  EXPECT_EQ(report["options"]["StructNeRF.field"], "mlp");
  EXPECT_EQ(report["options"]["StructNeRF.mlp_width"], 256);
  // Two networks of 8 layers of 256 with NeRF's heads, and the codes.
  EXPECT_GT(report["training"]["parameters"], 1'000'000);

  const std::string frames = folder + "/frames";
  const ProgramResult rendered = RunProgram({"structnerf_render",
                                             "--workspace_path",
                                             dense,
                                             "--output_path",
                                             frames,
                                             "--num_frames",
                                             "2"});
  ASSERT_EQ(rendered.exit_code, 0) << rendered.error;
  EXPECT_FALSE(ReadFolder(frames).empty());
}

}  // namespace
}  // namespace structnerf
