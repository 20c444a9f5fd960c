// What a person at a terminal sees, and what Ctrl-C does.

#include "tests/colmap_plugin/tiny_model.h"
#include "tests/end_to_end/json_files.h"
#include "tests/end_to_end/run_program.h"
#include "tests/support/temp_dir.h"

#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <iterator>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace structnerf {
namespace {

using testing::ContainsRegex;
using testing::HasSubstr;

class TerminalTest : public testing::Test {
 protected:
  TerminalTest() {
    const TinyModel model = MakeTinyModel(3);
    model.WriteImages(temp_dir_ / "images");
    model.WriteModel(temp_dir_ / "sparse");
    options_.arguments = {"structnerf_dense",
                          "--image_path",
                          temp_dir_ / "images",
                          "--input_path",
                          temp_dir_ / "sparse",
                          "--output_path",
                          temp_dir_ / "dense",
                          // No test waits for these.
                          "--StructNeRF.num_steps=100000000"};
  }

  TempDir temp_dir_;
  ProgramOptions options_;
};

TEST_F(TerminalTest, ShowsABarThatIsRedrawnInPlace) {
  options_.has_terminal = true;
  options_.arguments.back() = "--StructNeRF.num_steps=3000";
  const ProgramResult result = RunProgram(options_);
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.error, ContainsRegex("Training +.#+\\.+. [0-9]+ %"));
  EXPECT_THAT(result.error, HasSubstr(" left, loss "));
  // One line per stage in the end, and one per decision.
  EXPECT_LT(std::count(result.error.begin(), result.error.end(), '\n'), 23);
  EXPECT_THAT(result.out, HasSubstr("Points fused"));
}

TEST_F(TerminalTest, CtrlCOnceStopsTrainingAndWritesMaps) {
  Program program(options_);
  ASSERT_TRUE(program.WaitForError("Training\n"));
  program.Signal(SIGINT);
  const ProgramResult result = program.Wait();
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.error, HasSubstr("Press Ctrl-C again"));
  EXPECT_THAT(result.out, HasSubstr("stopped early"));
  EXPECT_TRUE(std::filesystem::exists(
      temp_dir_ / "dense/stereo/depth_maps/2.png.geometric.bin"));
  EXPECT_EQ(ReadReport(temp_dir_ / "dense")["training"]["stopped_early"], true);
}

TEST_F(TerminalTest, CtrlCTwiceLeavesTheDiskAsItWas) {
  const auto before = ReadFolder(temp_dir_.Path());
  // The second one can come too late, when these few maps are written.
  bool was_in_time = false;
  for (int i = 0; i < 20 && !was_in_time; ++i) {
    std::filesystem::remove_all(temp_dir_ / "dense");
    Program program(options_);
    ASSERT_TRUE(program.WaitForError("Training\n"));
    program.Signal(SIGINT);
    // Else the system would merge the two.
    std::this_thread::sleep_for(std::chrono::microseconds(500));
    program.Signal(SIGINT);
    const ProgramResult result = program.Wait();
    was_in_time = result.exit_code != 0;
    if (was_in_time) {
      EXPECT_EQ(result.exit_code, EXIT_FAILURE);
      EXPECT_THAT(result.error, HasSubstr("nothing was written"));
      EXPECT_EQ(ReadFolder(temp_dir_.Path()), before);
    }
  }
  EXPECT_TRUE(was_in_time);
}

TEST_F(TerminalTest, TerminationWithoutCheckpointsLeavesTheDiskAsItWas) {
  options_.arguments.push_back("--StructNeRF.checkpoint_minutes=0");
  const auto before = ReadFolder(temp_dir_.Path());
  Program program(options_);
  ASSERT_TRUE(program.WaitForError("Training\n"));
  EXPECT_NE(ReadFolder(temp_dir_.Path()), before);
  program.Signal(SIGTERM);
  const ProgramResult result = program.Wait();
  EXPECT_EQ(result.exit_code, EXIT_FAILURE);
  EXPECT_THAT(result.error, HasSubstr("nothing was written"));
  EXPECT_EQ(ReadFolder(temp_dir_.Path()), before);
}

}  // namespace
}  // namespace structnerf
