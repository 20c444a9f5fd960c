#include "ui/gui_arguments.h"

#include "tests/colmap_plugin/tiny_model.h"
#include "tests/support/temp_dir.h"
#include "ui/gui_window.h"

#include <QComboBox>
#include <QLabel>
#include <QLineEdit>
#include <QSpinBox>
#include <QTest>
#include <fstream>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace structnerf {
namespace {

using testing::HasSubstr;

bool Parse(std::vector<std::string>* args, GuiArguments* arguments) {
  std::vector<char*> argv;
  for (std::string& arg : *args) {
    argv.push_back(arg.data());
  }
  return ParseGuiArguments(
      static_cast<int>(argv.size()), argv.data(), arguments);
}

TEST(GuiArguments, ReachTheDialog) {
  const TempDir folder;
  const TinyModel model = MakeTinyModel(3);
  model.WriteModel(folder / "model");
  model.WriteImages(folder / "images");
  std::vector<std::string> args = {"colmap",
                                   "--database_path",
                                   folder / "database.db",
                                   "--import_path",
                                   folder / "model",
                                   "--image_path",
                                   folder / "images",
                                   "--StructNeRF.quality",
                                   "low",
                                   "--StructNeRF.method",
                                   "nerf",
                                   "--StructNeRF.num_steps",
                                   "123"};
  GuiArguments arguments;
  ASSERT_TRUE(Parse(&args, &arguments));

  EXPECT_EQ(arguments.options.method, "nerf");
  EXPECT_EQ(arguments.options.reconstruction.loss.patch_weight, 0);

  GuiWindow window(arguments.manager, &arguments.options);
  window.Show(arguments.import_path);
  auto* item = window.Window().findChild<QAction*>("structnerf_dense");
  ASSERT_TRUE(QTest::qWaitFor([&]() { return item->isEnabled(); }));
  item->trigger();
  const auto* quality = window.Window().findChild<QComboBox*>("quality");
  EXPECT_EQ(quality->currentText(), "low");
  const auto* method = window.Window().findChild<QComboBox*>("method");
  EXPECT_EQ(method->currentText(), "nerf");
  const auto* image_path = window.Window().findChild<QLineEdit*>("image_path");
  EXPECT_EQ(image_path->text().toStdString(), folder / "images");
  const auto* expectation = window.Window().findChild<QLabel*>("expectation");
  EXPECT_THAT(expectation->text().toStdString(), HasSubstr("3 images"));
  EXPECT_THAT(expectation->text().toStdString(), HasSubstr("123 steps"));
}

TEST(GuiArguments, WinOverTheProject) {
  const TempDir folder;
  const std::string project_path = folder / "project.ini";
  colmap::OptionManager manager;
  manager.AddAllOptions();
  *manager.database_path = folder / "database.db";
  *manager.image_path = folder / "images";
  MakeTinyModel(2).WriteImages(folder / "images");
  manager.Write(project_path);
  std::ofstream(project_path, std::ios::app)
      << "[StructNeRF]\nquality=low\nnum_steps=12\nseed=3\n";
  std::vector<std::string> args = {
      "colmap", "--project_path", project_path, "--StructNeRF.num_steps=34"};
  GuiArguments arguments;
  ASSERT_TRUE(Parse(&args, &arguments));
  EXPECT_EQ(arguments.options.quality, "low");
  EXPECT_EQ(arguments.options.reconstruction.training.max_image_size,
            QualityPreset("low").training.max_image_size);
  EXPECT_EQ(arguments.options.reconstruction.training.num_steps, 34);
  EXPECT_EQ(arguments.options.reconstruction.training.seed, 3);
}

}  // namespace
}  // namespace structnerf
