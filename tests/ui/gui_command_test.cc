#include "ui/gui_command.h"

#include <cstdlib>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace structnerf {
namespace {

using testing::HasSubstr;

// What is said when no window can be opened.
std::string RunAndFail(std::vector<std::string> args) {
  std::vector<char*> argv;
  for (std::string& arg : args) {
    argv.push_back(arg.data());
  }
  testing::internal::CaptureStderr();
  EXPECT_EQ(RunGui(static_cast<int>(argv.size()), argv.data()), EXIT_FAILURE);
  return testing::internal::GetCapturedStderr();
}

TEST(GuiCommand, WithoutDisplaySaysSo) {
  for (const char* name : {"DISPLAY", "WAYLAND_DISPLAY", "QT_QPA_PLATFORM"}) {
    setenv(name, "", /*overwrite=*/1);
  }
  EXPECT_THAT(RunAndFail({"colmap"}), HasSubstr("no display"));
}

TEST(GuiCommand, RefusesAnUnknownQuality) {
  EXPECT_THAT(RunAndFail({"colmap", "--StructNeRF.quality", "best"}),
              HasSubstr("low, medium, high"));
}

}  // namespace
}  // namespace structnerf
