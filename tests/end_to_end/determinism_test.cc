// The same seed gives the same files on any number of threads. Not so
// fused.ply: COLMAP's fusion takes the rows of an image on all cores at once,
// and which of them claims a pixel first decides which point it goes into.

#include "tests/end_to_end/resumed_run.h"

#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace structnerf {
namespace {

using DeterminismTest = ResumedRunTest;

TEST_F(DeterminismTest, SameFilesOnAnyNumberOfThreads) {
  for (const char* num_threads : {"1", "2", "3"}) {
    const std::string output = std::string("threads") + num_threads;
    SCOPED_TRACE(output);
    ExpectResult(
        Command({std::string("--StructNeRF.num_threads=") + num_threads},
                output),
        output);
  }
}

TEST_F(DeterminismTest, OnlyTheCloudDependsOnTheThreadsOfFusion) {
  for (int run = 0; run < 2; ++run) {
    const std::string output = "run" + std::to_string(run);
    const ProgramResult result =
        RunProgram(Command({"--StereoFusion.num_threads=3"}, output));
    ASSERT_EQ(result.exit_code, 0) << result.error;
    const auto files = ReadResult(output);
    for (const auto& [name, content] : expected_) {
      if (name.rfind("fused.ply", 0) != 0) {
        EXPECT_TRUE(files.at(name) == content) << name;
      }
    }
  }
}

TEST_F(DeterminismTest, AnotherSeedGivesAnotherResult) {
  ASSERT_EQ(RunProgram(Command({"--StructNeRF.seed=1"}, "seed")).exit_code, 0);
  EXPECT_NE(ReadResult("seed").at("stereo/depth_maps/0.png.photometric.bin"),
            expected_.at("stereo/depth_maps/0.png.photometric.bin"));
}

TEST_F(DeterminismTest, ColmapsSeedIsTakenIfOursIsNotGiven) {
  for (const auto& [arguments, seed] :
       {std::pair(std::vector<std::string>{"--random_seed=5"}, "5"),
        std::pair(
            std::vector<std::string>{"--random_seed=5", "--StructNeRF.seed=3"},
            "3")}) {
    std::vector<std::string> all = {"structnerf_dense",
                                    "--StructNeRF.print_options=1"};
    all.insert(all.end(), arguments.begin(), arguments.end());
    EXPECT_NE(RunProgram(all).out.find(std::string("StructNeRF.seed = ") +
                                       seed + "\n"),
              std::string::npos);
  }
}

}  // namespace
}  // namespace structnerf
