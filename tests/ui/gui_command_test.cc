#include "ui/gui_command.h"

#include "tests/colmap_plugin/tiny_model.h"
#include "tests/support/temp_dir.h"

#include <QGuiApplication>
#include <QImage>
#include <QPixmap>
#include <QProcess>
#include <QScreen>
#include <QTest>
#include <cstdlib>
#include <string>
#include <utility>
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

QImage Screen() {
  return QGuiApplication::primaryScreen()->grabWindow(0).toImage();
}

size_t NumDifferentPixels(const QImage& a, const QImage& b) {
  size_t count = 0;
  for (int row = 0; row < a.height(); ++row) {
    for (int col = 0; col < a.width(); ++col) {
      count += a.pixel(col, row) != b.pixel(col, row);
    }
  }
  return count;
}

TEST(GuiCommand, WithoutDisplaySaysSo) {
  std::vector<std::pair<const char*, QByteArray>> values;
  for (const char* name : {"DISPLAY", "WAYLAND_DISPLAY", "QT_QPA_PLATFORM"}) {
    values.emplace_back(name, qgetenv(name));
    qputenv(name, "");
  }
  EXPECT_THAT(RunAndFail({"colmap"}), HasSubstr("no display"));
  for (const auto& [name, value] : values) {
    qputenv(name, value);
  }
}

TEST(GuiCommand, RefusesAnUnknownQuality) {
  EXPECT_THAT(RunAndFail({"colmap", "--StructNeRF.quality", "best"}),
              HasSubstr("low, medium, high"));
}

// The program itself, seen from outside.
TEST(GuiCommand, OpensAWindow) {
  const TempDir folder;
  const TinyModel model = MakeTinyModel(3);
  model.WriteModel(folder / "model");
  model.WriteImages(folder / "images");
  const QImage empty_screen = Screen();
  QProcess program;
  program.start(STRUCTNERF_PROGRAM,
                {"gui",
                 "--database_path",
                 QString::fromStdString(folder / "database.db"),
                 "--import_path",
                 QString::fromStdString(folder / "model"),
                 "--image_path",
                 QString::fromStdString(folder / "images"),
                 "--StructNeRF.quality",
                 "low"});
  // COLMAP's window covers 1024x600 pixels.
  EXPECT_TRUE(QTest::qWaitFor(
      [&]() { return NumDifferentPixels(Screen(), empty_screen) > 500000; },
      /*timeout=*/60000))
      << program.readAllStandardError().toStdString();
  EXPECT_TRUE(Screen().save(STRUCTNERF_SCREENSHOTS "/program.png"));
  EXPECT_EQ(program.state(), QProcess::Running);
  program.kill();
  EXPECT_TRUE(program.waitForFinished());
}

}  // namespace
}  // namespace structnerf
