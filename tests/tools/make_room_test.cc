// Runs the program as a user does.

#include "tests/support/temp_dir.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

namespace structnerf {
namespace {

using testing::HasSubstr;

class MakeRoom : public testing::Test {
 protected:
  // Returns the exit code; what was printed is in `output_`.
  int Run(const std::string& arguments) {
    const std::string log = dir_ / "log";
    const std::string command =
        "'" MAKE_ROOM_PROGRAM "' " + arguments + " >'" + log + "' 2>&1";
    const int status = std::system(command.c_str());
    std::ifstream file(log);
    output_.assign(std::istreambuf_iterator<char>(file), {});
    return WEXITSTATUS(status);
  }

  // One line that says what is wrong, and no folder.
  void ExpectError(const std::string& arguments, const std::string& message) {
    EXPECT_NE(Run(dir_ / "room" + " " + arguments), 0);
    EXPECT_THAT(output_, HasSubstr(message));
    EXPECT_EQ(std::count(output_.begin(), output_.end(), '\n'), 1) << output_;
    EXPECT_FALSE(std::filesystem::exists(dir_ / "room"));
  }

  TempDir dir_;
  std::string output_;
};

TEST_F(MakeRoom, WritesARoom) {
  ASSERT_EQ(Run(dir_ / "room" + " --views 5 --width 64 --height 48"
                                " --camera_models PINHOLE,SIMPLE_RADIAL"
                                " --sub_folders 1 --fault exposure_jump"),
            0)
      << output_;
  EXPECT_THAT(output_, HasSubstr("5 images"));
  for (const char* name : {"sparse/0/cameras.txt",
                           "images/walk_b/frame_0001.png",
                           "depth/walk_b/frame_0001.png",
                           "normal/walk_a/frame_0002.png"}) {
    EXPECT_TRUE(std::filesystem::exists(dir_.Path() / "room" / name)) << name;
  }
  EXPECT_FALSE(std::filesystem::exists(dir_ / "room/fault"));
  EXPECT_NE(Run(dir_ / "room"), 0);
  EXPECT_THAT(output_, HasSubstr("not empty"));
}

TEST_F(MakeRoom, SaysWhatIsWrong) {
  ExpectError("--view 5", "--view;");
  ExpectError("--views", "--views needs a value");
  ExpectError("--views many", "not a number: many");
  ExpectError("--views 5.5", "not a number: 5.5");
  ExpectError("--views 1", "num_views must be 4 to 1000");
  ExpectError("--fault rain", "Unknown fault rain");
  ExpectError("--camera_models FOV", "camera_models must be among");
}

TEST_F(MakeRoom, HelpNamesOptionsAndFaults) {
  EXPECT_EQ(Run("--help"), 0);
  EXPECT_THAT(output_, HasSubstr("--camera_models"));
  EXPECT_THAT(output_, HasSubstr("wrong_point_cluster"));
  EXPECT_NE(Run(""), 0);
}

}  // namespace
}  // namespace structnerf
