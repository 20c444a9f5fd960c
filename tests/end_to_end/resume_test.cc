// A run that was killed goes on to the very result of one that was not.

#include "tests/end_to_end/resumed_run.h"

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

namespace structnerf {
namespace {

namespace fs = std::filesystem;

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

class ResumeTest : public ResumedRunTest {
 protected:
  // Whether all results are where they belong, whatever comes after that.
  bool HasMovedResults() const {
    return fs::exists(temp_dir_ / "dense/fused.ply") &&
           !fs::exists(StagedPath() + "/.resume/commit");
  }
};

// Set STRUCTNERF_KILLS for more of them.
int NumKills() {
  const char* const text = std::getenv("STRUCTNERF_KILLS");
  return text != nullptr ? std::atoi(text) : 8;
}

void FlipBit(const std::string& path, const std::streamoff position) {
  std::fstream file(path, std::ios::binary | std::ios::in | std::ios::out);
  file.seekg(position);
  const char byte = static_cast<char>(file.get());
  file.seekp(position);
  file.put(static_cast<char>(byte ^ 16));
}

// Checkpoints are written all the time, so most of these come during a write.
TEST_F(ResumeTest, KilledAtRandomTimes) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> share(0.0, 1.2);
  int num_kills = 0;
  int num_completed = 0;
  while (num_kills < NumKills()) {
    Program program(Command());
    if (program.WaitFor(share(random) * seconds_)) {
      const ProgramResult result = program.Wait();
      ASSERT_EQ(result.exit_code, 0) << result.error;
    } else {
      program.Signal(SIGKILL);
      program.Wait();
      ++num_kills;
      if (!HasMovedResults()) {
        continue;
      }
      fs::remove_all(StagedPath());  // it was about to
    }
    EXPECT_TRUE(ReadResult() == expected_);
    ++num_completed;
    fs::remove_all(temp_dir_ / "dense");
  }
  ExpectResult(Command());
  std::printf("%d kills, %d runs completed\n", num_kills, num_completed + 1);
}

TEST_F(ResumeTest, TerminationSavesWhatWasLearned) {
  // No other checkpoint is due, and no test waits for the end.
  Program program(Command({"--StructNeRF.num_steps=100000000",
                           "--StructNeRF.checkpoint_minutes=1000"}));
  ASSERT_TRUE(program.WaitForError("Training\n"));
  EXPECT_FALSE(program.WaitFor(2));
  program.Signal(SIGTERM);
  const ProgramResult result = program.Wait();
  EXPECT_EQ(result.exit_code, EXIT_FAILURE);
  EXPECT_THAT(result.error,
              AllOf(HasSubstr("The same command goes on"),
                    HasSubstr(StagedPath()),
                    Not(HasSubstr("nothing was written"))));
  EXPECT_TRUE(fs::exists(CheckpointPath()));
}

TEST_F(ResumeTest, GoesOnAfterTermination) {
  Terminate();
  EXPECT_THAT(ExpectResult(Command()).error,
              HasSubstr("Going on with the run"));
  EXPECT_FALSE(fs::exists(StagedPath()));
}

TEST_F(ResumeTest, CtrlCTwiceRemovesAll) {
  Terminate();
  // The system merges two signals if the program has no time between them, and
  // ends the run at the first if it has too much. What is kept then goes on.
  bool was_in_time = false;
  for (int attempt = 0; attempt < 10 && !was_in_time; ++attempt) {
    Program program(Command({"--StructNeRF.checkpoint_minutes=1000"}));
    ASSERT_TRUE(program.WaitForError("Undistorting"));
    program.Signal(SIGINT);
    std::this_thread::sleep_for(std::chrono::milliseconds(1 << attempt / 2));
    program.Signal(SIGINT);
    const ProgramResult result = program.Wait();
    ASSERT_NE(result.exit_code, EXIT_SUCCESS);
    was_in_time =
        result.error.find("The same command goes on") == std::string::npos;
    EXPECT_EQ(fs::exists(StagedPath()), !was_in_time);
  }
  EXPECT_TRUE(was_in_time);
}

TEST_F(ResumeTest, ViewsAreNotRenderedAgain) {
  // Slow enough to be killed in the middle.
  const ProgramOptions command =
      Command({"--StructNeRF.stereo_num_iterations=40"});
  const std::string folder = "/structnerf/interim/";
  std::vector<std::string> maps;
  {
    Program program(command);
    ASSERT_TRUE(program.WaitForError("Rendering"));
    while (maps.size() < 2) {
      ASSERT_FALSE(program.WaitFor(0.001));
      for (const TinyModel::Image& image : model_.images) {
        const std::string name = image.name + ".matched.bin";
        if (std::count(maps.begin(), maps.end(), name) == 0 &&
            fs::exists(StagedPath() + folder + name)) {
          maps.push_back(name);
        }
      }
    }
    program.Signal(SIGKILL);
    program.Wait();
  }
  // In the order in which they were written; the last may lack its line in the
  // journal.
  std::sort(maps.begin(), maps.end(), [&](const auto& a, const auto& b) {
    return fs::last_write_time(StagedPath() + folder + a) <
           fs::last_write_time(StagedPath() + folder + b);
  });
  const auto time = fs::last_write_time(StagedPath() + folder + maps[0]);
  const auto image_time = fs::last_write_time(StagedPath() + "/images/0.png");
  std::ofstream(StagedPath() + folder + maps.back()) << "damaged";
  {
    Program program(command);
    ASSERT_TRUE(program.WaitForError("Completing planes"));
    EXPECT_EQ(fs::last_write_time(StagedPath() + folder + maps[0]), time);
    EXPECT_GT(fs::file_size(StagedPath() + folder + maps.back()), 1000u);
    EXPECT_EQ(program.Wait().exit_code, 0);
  }
  EXPECT_EQ(fs::last_write_time(temp_dir_ / "dense/images/0.png"), image_time);

  const auto resumed = ReadResult();
  fs::remove_all(temp_dir_ / "dense");
  EXPECT_EQ(RunProgram(command).exit_code, 0);
  EXPECT_TRUE(ReadResult() == resumed);
}

TEST_F(ResumeTest, DamagedCheckpointsArePassedOver) {
  Terminate();
  // Another one makes the first the older one.
  {
    Program program(Command());
    ASSERT_TRUE(program.WaitForError("Training\n"));
    while (!fs::exists(StagedPath() + "/.resume/checkpoint.older.bin")) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    program.Signal(SIGKILL);
    program.Wait();
  }
  fs::remove(CheckpointPath() + ".partial");
  if (!fs::exists(CheckpointPath())) {  // it was killed between two renamings
    fs::copy_file(StagedPath() + "/.resume/checkpoint.older.bin",
                  CheckpointPath());
  }
  const TempDir copy;
  fs::copy(StagedPath(), copy.Path(), fs::copy_options::recursive);
  const auto restore = [&]() {
    fs::remove_all(temp_dir_ / "dense");
    fs::create_directory(temp_dir_ / "dense");
    fs::copy(copy.Path(), StagedPath(), fs::copy_options::recursive);
  };
  restore();
  FlipBit(CheckpointPath(), 1000);
  EXPECT_THAT(ExpectResult(Command()).error,
              AllOf(HasSubstr("Warning: " + CheckpointPath() + " is damaged"),
                    HasSubstr("the one before it is used"),
                    HasSubstr("Going on")));
  restore();
  fs::resize_file(CheckpointPath(), fs::file_size(CheckpointPath()) / 2);
  EXPECT_THAT(ExpectResult(Command()).error, HasSubstr("is damaged"));
  // Both: all is lost but nothing is wrong.
  restore();
  fs::resize_file(CheckpointPath(), 100);
  fs::resize_file(StagedPath() + "/.resume/checkpoint.older.bin", 0);
  EXPECT_THAT(ExpectResult(Command()).error, HasSubstr("training begins anew"));
}

TEST_F(ResumeTest, OtherOptionsAreRefused) {
  Terminate();
  const auto before = ReadFolder(StagedPath());
  const ProgramResult result = RunProgram(
      Command({"--StructNeRF.num_steps=300", "--StructNeRF.seed=1"}));
  EXPECT_EQ(result.exit_code, EXIT_FAILURE);
  EXPECT_THAT(
      result.error,
      AllOf(HasSubstr("--StructNeRF.num_steps is 200 there and 300 now"),
            HasSubstr("--StructNeRF.seed is 0 there and 1 now"),
            HasSubstr("--StructNeRF.resume 0"),
            Not(HasSubstr("The same command goes on"))));
  EXPECT_EQ(ReadFolder(StagedPath()), before);
  // More threads and more memory are no other run.
  ExpectResult(
      Command({"--StructNeRF.num_threads=3", "--StructNeRF.max_memory_gb=8"}));
}

TEST_F(ResumeTest, ResumeZeroStartsAnew) {
  Terminate();
  const ProgramResult result = RunProgram(
      Command({"--StructNeRF.num_steps=10", "--StructNeRF.resume=0"}));
  EXPECT_EQ(result.exit_code, 0) << result.error;
  EXPECT_THAT(result.error, Not(HasSubstr("Going on")));
  EXPECT_FALSE(ReadResult() == expected_);
}

TEST_F(ResumeTest, OtherDataAreRefused) {
  Terminate();
  const std::string image = temp_dir_ / "images/2.png";
  fs::copy_file(image, temp_dir_ / "2.png");
  cv::imwrite(image, RandomImage(64, 48, 77));
  const ProgramResult result = RunProgram(Command());
  EXPECT_EQ(result.exit_code, EXIT_FAILURE);
  EXPECT_THAT(result.error,
              AllOf(HasSubstr("photographs"), HasSubstr("resume 0")));
  // With the photograph back, which now has another time, it goes on.
  fs::copy_file(
      temp_dir_ / "2.png", image, fs::copy_options::overwrite_existing);
  EXPECT_THAT(ExpectResult(Command()).error, HasSubstr("Going on"));
}

// What is left of another scene must not get into the result.
TEST_F(ResumeTest, RemainsOfAnotherSceneAreRemoved) {
  fs::create_directories(StagedPath() + "/stereo/depth_maps");
  std::ofstream(StagedPath() + "/stereo/depth_maps/old.png.geometric.bin")
      << "of another scene";
  ExpectResult(Command());
}

// Killed in the middle of moving the results to where they belong.
TEST_F(ResumeTest, KilledWhileResultsAreMoved) {
  Terminate();
  fs::create_directories(temp_dir_ / "dense/stereo/depth_maps");
  const std::string name = "images/0.png";
  fs::create_directories(temp_dir_ / "dense/images");
  fs::rename(StagedPath() + "/" + name, temp_dir_ / "dense/" + name);
  std::ofstream(StagedPath() + "/.resume/commit", std::ios::binary)
      << name << '\0' << "fused.ply" << '\0' << "images/" << '\0' << "stereo/"
      << '\0' << "stereo/depth_maps/" << '\0';
  EXPECT_THAT(ExpectResult(Command()).error, HasSubstr("Going on"));
}

}  // namespace
}  // namespace structnerf
