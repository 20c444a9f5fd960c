// A user's way through COLMAP's window, with real events on a real screen.

#include "tests/colmap_plugin/tiny_model.h"
#include "tests/ui/dense_window_fixture.h"
#include "tests/ui/freeze_watch.h"
#include "ui/comparison_bar.h"
#include "ui/map_viewer.h"

#include <QAction>
#include <QComboBox>
#include <QDesktopServices>
#include <QLabel>
#include <QLineEdit>
#include <QMenu>
#include <QMenuBar>
#include <QProgressBar>
#include <QPushButton>
#include <QTableWidget>
#include <QTest>
#include <QTextBrowser>
#include <QToolBar>
#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace structnerf {
namespace {

namespace fs = std::filesystem;

using testing::EndsWith;
using testing::HasSubstr;
using testing::StartsWith;

using DenseWindowTest = DenseWindowFixture;

TEST_F(DenseWindowTest, TheItemIsThereAndEnabledWithAModel) {
  const auto* item = Item();
  ASSERT_NE(item, nullptr);
  EXPECT_EQ(item->text(), "StructNeRF dense reconstruction");
  EXPECT_FALSE(item->icon().isNull());
  EXPECT_FALSE(item->shortcut().isEmpty());
  int num_places = 0;
  for (const auto* menu : window_->Window().findChildren<QMenu*>()) {
    num_places += menu->title() == "Reconstruction" &&
                  menu->actions().contains(const_cast<QAction*>(item));
  }
  for (const auto* tool_bar : window_->Window().findChildren<QToolBar*>()) {
    num_places += tool_bar->windowTitle() == "Reconstruction" &&
                  tool_bar->actions().contains(const_cast<QAction*>(item));
  }
  EXPECT_EQ(num_places, 2);
  EXPECT_FALSE(item->isEnabled());

  window_->Window().ImportReconstruction(*temp_dir_ / "room/sparse/0");
  EXPECT_TRUE(QTest::qWaitFor([&]() { return item->isEnabled(); }));
  Screenshot(&window_->Window(), "main_window");

  QAction* pause = PauseAction();
  ASSERT_NE(pause, nullptr);
  pause->setEnabled(true);
  EXPECT_TRUE(QTest::qWaitFor([&]() { return !item->isEnabled(); }));
  pause->setEnabled(false);
  EXPECT_TRUE(QTest::qWaitFor([&]() { return item->isEnabled(); }));
}

TEST_F(DenseWindowTest, OneImageIsNotEnough) {
  const TinyModel model = MakeTinyModel(1);
  model.WriteModel(*temp_dir_ / "one_image");
  window_->Window().ImportReconstruction(*temp_dir_ / "one_image");
  ASSERT_NE(Viewer()->reconstruction, nullptr);
  EXPECT_EQ(Viewer()->reconstruction->NumRegImages(), 1u);
  QTest::qWait(kAnswerMilliseconds);
  EXPECT_FALSE(Item()->isEnabled());
}

TEST_F(DenseWindowTest, KeyAndMenuOpenTheDialog) {
  window_->Window().ImportReconstruction(*temp_dir_ / "room/sparse/0");
  ASSERT_TRUE(QTest::qWaitFor([this]() { return Item()->isEnabled(); }));
  QWidget* dialog = Tabs()->window();
  window_->Window().activateWindow();
  ASSERT_TRUE(QTest::qWaitForWindowActive(&window_->Window()));
  QTest::keyClick(&window_->Window(), Qt::Key_D, Qt::ControlModifier);
  EXPECT_TRUE(dialog->isVisible());
  dialog->close();

  QMenuBar* bar = window_->Window().menuBar();
  for (QAction* title : bar->actions()) {
    if (title->text() == "Reconstruction") {
      QTest::mouseClick(
          bar, Qt::LeftButton, {}, bar->actionGeometry(title).center());
      QMenu* menu = title->menu();
      ASSERT_TRUE(QTest::qWaitForWindowExposed(menu));
      Screenshot(menu, "menu");
      QTest::mouseClick(
          menu, Qt::LeftButton, {}, menu->actionGeometry(Item()).center());
    }
  }
  EXPECT_TRUE(dialog->isVisible());
}

// Though the dialog came up with another one.
TEST_F(DenseWindowTest, StartTakesTheModelThatIsShown) {
  OpenDialog();
  MakeTinyModel(1).WriteModel(*temp_dir_ / "one_image_more");
  window_->Window().ImportReconstruction(*temp_dir_ / "one_image_more");
  ASSERT_EQ(Viewer()->reconstruction->NumRegImages(), 1u);
  AnswerMessage(QMessageBox::Ok, "message_other_model");
  Click("start");
  EXPECT_TRUE(
      QTest::qWaitFor([&]() { return !message_.empty(); }, kRunMilliseconds));
  EXPECT_THAT(message_, HasSubstr("1 registered images"));
}

TEST_F(DenseWindowTest, RunsToTheEndAndShowsTheResults) {
  OpenDialog();
  EXPECT_EQ(Find<QLineEdit>("image_path")->text().toStdString(),
            *temp_dir_ / "room/images");
  EXPECT_EQ(Find<QComboBox>("quality")->currentText(), "low");
  EXPECT_THAT(Find<QLabel>("expectation")->text().toStdString(),
              HasSubstr("8 images"));
  Screenshot(Tabs()->window(), "setup");
  Tabs()->setCurrentIndex(1);
  Screenshot(Tabs()->window(), "advanced");
  Tabs()->setCurrentIndex(0);
  SetNumSteps(4000);  // enough for several previews

  const FreezeWatch freezes;
  Click("start");
  ASSERT_TRUE(WaitForTraining());
  const auto* bar = Find<QProgressBar>("bar");
  const int first_value = bar->value();
  EXPECT_TRUE(QTest::qWaitFor([&]() { return bar->value() > first_value + 50; },
                              kRunMilliseconds));
  EXPECT_THAT(Find<QLabel>("time_left")->text().toStdString(),
              EndsWith(" left"));
  const size_t num_losses = Curve("loss").size();
  EXPECT_GT(num_losses, 0u);

  EXPECT_EQ(Find<QComboBox>("image")->count(), 8);
  for (const char* name : {"Photograph", "Rendered", "Depth", "Normals"}) {
    const auto* picture = Find<QLabel>(name);
    EXPECT_TRUE(QTest::qWaitFor(
        [&]() { return !picture->pixmap(Qt::ReturnByValue).isNull(); },
        kRunMilliseconds))
        << name;
  }

  const auto* rendered = Find<QLabel>("Rendered");
  const qint64 first_preview = rendered->pixmap(Qt::ReturnByValue).cacheKey();
  EXPECT_TRUE(
      QTest::qWaitFor([&]() { return bar->value() > 700; }, kRunMilliseconds));
  EXPECT_NE(rendered->pixmap(Qt::ReturnByValue).cacheKey(), first_preview);
  EXPECT_GT(Curve("loss").size(), num_losses);
  EXPECT_LT(Curve("loss").back().value, Curve("loss").front().value);
  EXPECT_GT(Curve("psnr").size(), 1u);
  Click("pause");
  QTest::qWait(kAnswerMilliseconds);
  EXPECT_EQ(Find<QLabel>("stage")->text(), "Training (paused)");
  Screenshot(Tabs()->window(), "run");
  Click("pause");

  ASSERT_TRUE(WaitForTab(3)) << message_;
  ASSERT_TRUE(WaitForCloud());
  EXPECT_TRUE(fs::exists(WorkspacePath() + "/fused.ply"));
  const auto* views = Find<QTableWidget>("views");
  ASSERT_EQ(views->rowCount(), 8);
  Screenshot(Tabs()->window(), "results");

  // The cloud is in the viewer, with the cameras around it.
  EXPECT_EQ(Viewer()->reconstruction->NumRegImages(), 8u);
  const size_t num_cloud_points = Viewer()->points3D.size();
  Click("show_model");
  EXPECT_NE(Viewer()->points3D.size(), num_cloud_points);
  Click("show_cloud");
  ASSERT_TRUE(WaitForCloud());
  EXPECT_EQ(Viewer()->points3D.size(), num_cloud_points);
  EXPECT_GT(num_cloud_points, 100u);
  RecordProperty("longest_freeze_ms",
                 static_cast<int>(freezes.LongestMilliseconds()));
  EXPECT_LT(freezes.LongestMilliseconds(), kAnswerMilliseconds);

  EXPECT_TRUE(QTest::qWaitFor([&]() {
    return Log().contains(
        QString::fromStdString("points in " + WorkspacePath()));
  })) << Log().toStdString();
  EXPECT_TRUE(Log().contains("StructNeRF: Training"));
  EXPECT_TRUE(Log().contains("StructNeRF: Fusing points"));

  Click("depth_map");
  auto* map_viewer = dynamic_cast<MapViewer*>(Find<QLabel>("value")->window());
  ASSERT_NE(map_viewer, nullptr);
  EXPECT_TRUE(map_viewer->isVisible());
  EXPECT_EQ(map_viewer->windowTitle().left(9), "Depth map");
  Screenshot(map_viewer, "depth_map");
  Click("normal_map");
  Screenshot(map_viewer, "normal_map");
  Click("confidence");
  Screenshot(map_viewer, "confidence");
  map_viewer->hide();

  // A browser that shows the page.
  const std::string other_path = *temp_dir_ / "other_dense";
  fs::copy(WorkspacePath(), other_path, fs::copy_options::recursive);
  EXPECT_EQ(FindOtherWorkspace(WorkspacePath()), other_path);
  EXPECT_EQ(FindOtherWorkspace(other_path), WorkspacePath());
  QTextBrowser browser;
  QDesktopServices::setUrlHandler("file", &browser, "setSource");
  Click("open_folder");
  EXPECT_EQ(browser.source().toLocalFile().toStdString(), WorkspacePath());
  Find<QLineEdit>("other_path")->setText(QString::fromStdString(other_path));
  Click("compare");
  Click("compare");  // cancels it
  const auto* compare = Find<QPushButton>("compare");
  EXPECT_TRUE(QTest::qWaitFor([&]() { return compare->text() == "Compare"; },
                              kAnswerMilliseconds));
  EXPECT_FALSE(fs::exists(WorkspacePath() + "/structnerf/comparison"));
  Click("compare");
  EXPECT_TRUE(QTest::qWaitFor([&]() { return compare->text() == "Compare"; },
                              kRunMilliseconds));
  QDesktopServices::unsetUrlHandler("file");
  const std::string page = browser.source().toLocalFile().toStdString();
  EXPECT_THAT(page, StartsWith(WorkspacePath() + "/structnerf/comparison"));
  EXPECT_TRUE(fs::exists(page));
  AnswerMessage(QMessageBox::Ok, "message_bad_comparison");
  Find<QLineEdit>("other_path")->setText("/no/such/folder");
  Click("compare");
  EXPECT_TRUE(QTest::qWaitFor([&]() { return !message_.empty(); },
                              kAnswerMilliseconds));
  EXPECT_THAT(message_, HasSubstr("/no/such/folder"));

  Tabs()->window()->hide();
  Screenshot(&window_->Window(), "cloud");
  EXPECT_TRUE(IsFusionOffered(WorkspacePath()));
  EXPECT_FALSE(IsFusionOffered(*temp_dir_ / "room"));

  // Where no model was shown before the cloud, none is after it.
  Viewer()->ClearReconstruction();
  Click("show_cloud");
  ASSERT_TRUE(WaitForCloud());
  Click("show_model");
  EXPECT_TRUE(Viewer()->points3D.empty());
  EXPECT_EQ(Viewer()->reconstruction, nullptr);
}

}  // namespace
}  // namespace structnerf
