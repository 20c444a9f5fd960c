// Disks that are full or cannot be written, memory that does not suffice,
// images that are damaged on the way: one clear error, nothing that was there
// is lost, and the same command goes on when the fault is mended.

#include "tests/end_to_end/resumed_run.h"

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/mount.h>

namespace structnerf {
namespace {

namespace fs = std::filesystem;

using testing::HasSubstr;
using testing::IsSupersetOf;
using testing::Not;

class FaultTest : public ResumedRunTest {
 protected:
  // Fails unless the run ends with one error that contains the text.
  void ExpectError(const ProgramOptions& options, const std::string& text) {
    ExpectError(RunProgram(options), text);
  }

  void ExpectError(const ProgramResult& result, const std::string& text) {
    EXPECT_EQ(result.exit_code, EXIT_FAILURE) << result.signal;
    EXPECT_THAT(result.error, HasSubstr(text));
    const size_t begin = result.error.find("ERROR: ");
    ASSERT_NE(begin, std::string::npos) << result.error;
    EXPECT_EQ(
        std::count(result.error.begin() + begin, result.error.end(), '\n'), 1)
        << result.error;
  }

  // The stage whose name was printed last.
  static std::string LastStage(const std::string& output) {
    std::string last;
    size_t last_begin = 0;
    for (const std::string stage : {"Undistorting",
                                    "Loading",
                                    "Training",
                                    "Rendering",
                                    "Completing",
                                    "Checking",
                                    "Fusing",
                                    "Averaging"}) {
      const size_t begin = output.rfind(stage);
      if (begin != std::string::npos && begin >= last_begin) {
        last = stage;
        last_begin = begin;
      }
    }
    return last;
  }

  // Trains to the end, but renders nothing.
  void TrainOnly() {
    ProgramOptions options = Command({"--StructNeRF.num_threads=1"});
    Program program(options);
    ASSERT_TRUE(program.WaitForError("Rendering"));
    program.Signal(SIGTERM);
    program.Wait();
    ASSERT_TRUE(fs::exists(CheckpointPath()));
    fs::remove_all(StagedPath() + "/stereo");
  }
};

// A disk of which every file can have so many bytes. Checkpoints have about
// 140 kB here, maps of normals 37 kB, the field 66 kB.
TEST_F(FaultTest, DiskThatIsFullAtAnyWrite) {
  for (const size_t size : {size_t{200}, size_t{5000}, size_t{100000}}) {
    SCOPED_TRACE(size);
    ProgramOptions options = Command();
    options.max_file_size = size;
    ExpectError(options, "full");
    EXPECT_FALSE(fs::exists(temp_dir_ / "dense"));
  }
  // Now with something that could be lost.
  for (const bool is_trained : {false, true}) {
    SCOPED_TRACE(is_trained);
    for (const size_t size : {size_t{20}, size_t{5000}, size_t{50000}}) {
      SCOPED_TRACE(size);
      if (!fs::exists(CheckpointPath())) {
        is_trained ? TrainOnly() : Terminate();
      }
      ProgramOptions options = Command();
      options.max_file_size = size;
      ExpectError(options, "full");
      EXPECT_TRUE(fs::exists(CheckpointPath()));
    }
    EXPECT_THAT(ExpectResult(Command()).error, HasSubstr("Going on"));
    fs::remove_all(temp_dir_ / "dense");
  }
}

// A real file system of few bytes that fills up in each stage.
TEST_F(FaultTest, FileSystemThatFillsUp) {
  const std::string disk = temp_dir_ / "disk";
  fs::create_directory(disk);
  if (mount("none", disk.c_str(), "tmpfs", 0, "size=16m") != 0) {
    GTEST_SKIP() << "cannot mount a file system: " << std::strerror(errno);
  }
  for (const std::string stage :
       {"Undistorting", "Training", "Checking", "Fusing", "Averaging"}) {
    SCOPED_TRACE(stage);
    Program program(Command({}, "disk/dense"));
    EXPECT_TRUE(program.WaitForError(stage));
    program.Signal(SIGSTOP);
    {
      std::ofstream ballast(disk + "/ballast");
      while (ballast << std::string(4096, 'x') << std::flush) {
      }
    }
    program.Signal(SIGCONT);
    const ProgramResult result = program.Wait();
    fs::remove(disk + "/ballast");
    if (result.exit_code != 0) {  // else it was done with that stage already
      ExpectError(result, "full");
      ExpectResult(Command({}, "disk/dense"), "disk/dense");
    }
    fs::remove_all(disk + "/dense");
  }
  // And one that cannot be written at all.
  EXPECT_EQ(
      mount("none", disk.c_str(), nullptr, MS_REMOUNT | MS_RDONLY, nullptr), 0);
  ExpectError(Command({}, "disk/dense"), "cannot be written");
  EXPECT_EQ(umount(disk.c_str()), 0);
}

// A file system that can hold a little more each time, so that it is full in
// one stage after the other; what was done before need not be done again.
TEST_F(FaultTest, FileSystemThatGrows) {
  const std::string disk = temp_dir_ / "disk";
  fs::create_directory(disk);
  if (mount("none", disk.c_str(), "tmpfs", 0, "size=20k") != 0) {
    GTEST_SKIP() << "cannot mount a file system: " << std::strerror(errno);
  }
  std::set<std::string> stages;
  size_t size = 20;
  while (true) {
    SCOPED_TRACE(size);
    ASSERT_LT(size, 100000u);
    const ProgramResult result = RunProgram(Command({}, "disk/dense"));
    if (result.exit_code == 0) {
      break;
    }
    const std::string stage = LastStage(result.error);
    // Before the first stage, what will be needed is compared with what is
    // left.
    ExpectError(result, stage.empty() ? "free some" : "full");
    stages.insert(stage);
    size += 8 * (1 + size / 100);
    const std::string option = "size=" + std::to_string(size) + "k";
    ASSERT_EQ(mount("none", disk.c_str(), nullptr, MS_REMOUNT, option.c_str()),
              0);
  }
  EXPECT_TRUE(ReadResult("disk/dense") == expected_);
  EXPECT_THAT(stages, IsSupersetOf({"", "Checking", "Averaging"}));
  EXPECT_EQ(umount(disk.c_str()), 0);
}

TEST_F(FaultTest, ImageThatBecomesUnreadable) {
  Terminate();
  const std::string image = temp_dir_ / "images/2.png";
  fs::copy_file(image, temp_dir_ / "2.png");
  fs::resize_file(image, 100);
  ExpectError(Command(), "2.png");
  EXPECT_TRUE(fs::exists(CheckpointPath()));
  fs::remove(image);
  ExpectError(Command(), "2.png");
  fs::copy_file(temp_dir_ / "2.png", image);
  EXPECT_THAT(ExpectResult(Command()).error, HasSubstr("Going on"));
}

TEST_F(FaultTest, UndistortedImageThatIsDamaged) {
  Terminate();
  fs::resize_file(StagedPath() + "/images/2.png", 100);
  EXPECT_THAT(ExpectResult(Command()).error, HasSubstr("Going on"));
}

#ifndef __SANITIZE_ADDRESS__  // which needs terabytes of address space
// From a limit at which the program can hardly start to one that suffices.
TEST_F(FaultTest, AddressSpaceThatDoesNotSuffice) {
  Terminate();
  int num_errors = 0;
  ProgramOptions options = Command();
  options.max_memory = size_t{600} << 20;
  while (true) {
    SCOPED_TRACE(options.max_memory);
    ASSERT_LT(options.max_memory, size_t{64} << 30);
    const ProgramResult result = RunProgram(options);
    if (result.exit_code == 0) {
      break;
    }
    EXPECT_TRUE(fs::exists(CheckpointPath()));
    if (result.error.find("ERROR: ") != std::string::npos) {
      ExpectError(result, "memory");
      ++num_errors;
    } else {  // libraries did not even get what they allocate before main()
      EXPECT_THAT(result.error, Not(HasSubstr("Going on")));
    }
    options.max_memory += options.max_memory / 8;
  }
  EXPECT_TRUE(ReadResult() == expected_);
  EXPECT_GT(num_errors, 0);
}

TEST_F(FaultTest, MemoryThatIsGoneAtAnyStage) {
  int num_errors = 0;
  for (const std::string stage :
       {"Undistorting", "Training", "Completing", "Fusing", "Averaging"}) {
    SCOPED_TRACE(stage);
    if (!fs::exists(CheckpointPath())) {
      Terminate();
    }
    Program program(Command({"--StructNeRF.num_threads=2"}));
    EXPECT_TRUE(program.WaitForError(stage));
    program.TakeMemory();
    const ProgramResult result = program.Wait();
    if (result.exit_code != 0) {  // else what it had was enough
      ExpectError(result, "memory");
      EXPECT_TRUE(fs::exists(CheckpointPath()));
      ++num_errors;
      ExpectResult(Command());
    }
    fs::remove_all(temp_dir_ / "dense");
  }
  EXPECT_GT(num_errors, 0);
}
#endif

}  // namespace
}  // namespace structnerf
