// A scene that is written on the way gives the same maps without COLMAP.

#include "tests/end_to_end/resumed_run.h"

#include <cstdlib>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace structnerf {
namespace {

using testing::HasSubstr;

using ExportTest = ResumedRunTest;

// The options of the method among those of the command.
std::string MethodArguments(const ProgramOptions& command) {
  std::string arguments;
  for (const std::string& argument : command.arguments) {
    if (argument.rfind("--StructNeRF.", 0) == 0 &&
        argument.find("checkpoint_minutes") == std::string::npos &&
        argument.find("export_path") == std::string::npos) {
      arguments += " " + argument;
    }
  }
  return arguments;
}

TEST_F(ExportTest, TrainingElsewhereGivesTheSameMaps) {
  const std::string scene_path = temp_dir_ / "scene.bin";
  const ProgramOptions command =
      Command({"--StructNeRF.export_path=" + scene_path});
  ExpectResult(command);

  const std::string maps_path = temp_dir_ / "maps";
  const std::string train = "'" STRUCTNERF_TRAIN "' --scene_path '" +
                            scene_path + "' --output_path '" + maps_path + "'" +
                            MethodArguments(command);
  ASSERT_EQ(std::system((train + " 2> /dev/null").c_str()), 0) << train;
  const auto maps = ReadFolder(maps_path);
  EXPECT_EQ(maps.size(), 3u + 4 * 4);  // folders and files
  for (const auto& [name, content] : maps) {
    ASSERT_EQ(expected_.count(name), 1u) << name;
    EXPECT_TRUE(content == expected_.at(name)) << name;
  }
}

TEST_F(ExportTest, NothingElseIsOverwritten) {
  const std::string path = temp_dir_ / "images/0.png";
  const ProgramResult result =
      RunProgram(Command({"--StructNeRF.export_path=" + path}));
  EXPECT_EQ(result.exit_code, EXIT_FAILURE);
  EXPECT_THAT(result.error, HasSubstr("--StructNeRF.export_path is " + path));
}

}  // namespace
}  // namespace structnerf
