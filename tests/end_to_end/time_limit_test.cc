// --StructNeRF.max_minutes: a run ends in time, and the quality follows.

#include "tests/colmap_plugin/tiny_model.h"
#include "tests/end_to_end/json_files.h"
#include "tests/end_to_end/run_program.h"
#include "tests/support/temp_dir.h"

#include <chrono>

#include <gtest/gtest.h>

namespace structnerf {
namespace {

class TimeLimitTest : public testing::Test {
 protected:
  TimeLimitTest() {
    TinyModel model = MakeTinyModel(4);
    model.WriteImages(temp_dir_ / "images");
    model.WriteModel(temp_dir_ / "sparse");
  }

  ProgramResult Run(const std::vector<std::string>& more_arguments) const {
    std::vector<std::string> arguments = {"structnerf_dense",
                                          "--image_path",
                                          temp_dir_ / "images",
                                          "--input_path",
                                          temp_dir_ / "sparse",
                                          "--output_path",
                                          temp_dir_ / "dense"};
    arguments.insert(
        arguments.end(), more_arguments.begin(), more_arguments.end());
    return RunProgram(arguments);
  }

  TempDir temp_dir_;
};

TEST_F(TimeLimitTest, ARunWithTooManyStepsEndsInTime) {
  const auto begin = std::chrono::steady_clock::now();
  const ProgramResult result = Run({"--StructNeRF.max_minutes=0.1",
                                    "--StructNeRF.num_steps=100000",
                                    "--StructNeRF.quality=low"});
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin)
          .count();
  ASSERT_EQ(result.exit_code, 0) << result.error;
  // All steps take minutes. What is not training may take longer than thought
  // on a busy machine.
  EXPECT_LT(seconds, 20);
  const auto report = ReadReport(temp_dir_ / "dense");
  EXPECT_GT(report["training"]["steps"], 10);
  EXPECT_LT(report["training"]["steps"], 100000);
  EXPECT_FALSE(report["training"]["stopped_early"]);
}

TEST_F(TimeLimitTest, TheQualityFollowsTheTime) {
  for (const auto& [minutes, quality] :
       {std::pair("1000", "high"), std::pair("0.0001", "low")}) {
    const ProgramResult result =
        Run({"--StructNeRF.print_options=1",
             std::string("--StructNeRF.max_minutes=") + minutes});
    ASSERT_EQ(result.exit_code, 0) << result.error;
    EXPECT_NE(result.out.find(std::string("StructNeRF.quality = ") + quality),
              std::string::npos)
        << result.out;
  }
}

TEST_F(TimeLimitTest, AQualityThatIsGivenStays) {
  const ProgramResult result = Run({"--StructNeRF.print_options=1",
                                    "--StructNeRF.max_minutes=1000",
                                    "--StructNeRF.quality=low",
                                    "--StructNeRF.num_levels=3"});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  EXPECT_NE(result.out.find("StructNeRF.quality = low"), std::string::npos);
  EXPECT_NE(result.out.find("StructNeRF.num_levels = 3"), std::string::npos);
}

TEST_F(TimeLimitTest, ToTellTheQualityAModelSuffices) {
  const ProgramResult result = RunProgram({"structnerf_dense",
                                           "--input_path",
                                           temp_dir_ / "sparse",
                                           "--StructNeRF.print_options=1",
                                           "--StructNeRF.max_minutes=1000"});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  EXPECT_NE(result.out.find("StructNeRF.quality = high"), std::string::npos)
      << result.out;
}

TEST_F(TimeLimitTest, TheQualityNeedsAModel) {
  const ProgramResult result = RunProgram({"structnerf_dense",
                                           "--StructNeRF.print_options=1",
                                           "--StructNeRF.max_minutes=5"});
  EXPECT_NE(result.exit_code, 0);
  EXPECT_NE(result.error.find("--input_path"), std::string::npos)
      << result.error;
}

}  // namespace
}  // namespace structnerf
