// A user's way through COLMAP's window, with real events on a real screen.

#include "colmap_plugin/structnerf_options.h"
#include "tests/colmap_plugin/tiny_model.h"
#include "tests/support/synthetic_room.h"
#include "tests/support/synthetic_room_writer.h"
#include "tests/support/temp_dir.h"
#include "tests/ui/freeze_watch.h"
#include "ui/comparison_bar.h"
#include "ui/curve_widget.h"
#include "ui/gui_window.h"
#include "ui/map_viewer.h"

#include <QAction>
#include <QApplication>
#include <QComboBox>
#include <QDesktopServices>
#include <QElapsedTimer>
#include <QLabel>
#include <QLineEdit>
#include <QMenu>
#include <QMenuBar>
#include <QMessageBox>
#include <QPlainTextEdit>
#include <QProgressBar>
#include <QPushButton>
#include <QScreen>
#include <QSpinBox>
#include <QTabWidget>
#include <QTableWidget>
#include <QTest>
#include <QTextBrowser>
#include <QTimer>
#include <QToolBar>
#include <filesystem>
#include <functional>
#include <memory>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace structnerf {
namespace {

namespace fs = std::filesystem;

using testing::EndsWith;
using testing::HasSubstr;
using testing::StartsWith;

constexpr int kAnswerMilliseconds = 1000;
constexpr int kRunMilliseconds = 300000;

class DenseWindowTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    temp_dir_ = std::make_unique<TempDir>();
    SyntheticRoomOptions room_options;
    room_options.num_views = 8;
    room_options.width = 160;
    room_options.height = 120;
    WriteSyntheticRoom(MakeSyntheticRoom(room_options), *temp_dir_ / "room");
  }

  static void TearDownTestSuite() { temp_dir_.reset(); }

  DenseWindowTest() {
    options_.quality = "low";
    options_.reconstruction = QualityPreset("low");
    colmap::OptionManager manager;
    *manager.image_path = *temp_dir_ / "room/images";
    window_ = std::make_unique<GuiWindow>(std::move(manager), &options_);
    window_->Show();
    EXPECT_TRUE(QTest::qWaitForWindowExposed(&window_->Window()));
  }

  // A folder of this test's own that does not exist yet.
  std::string WorkspacePath() const {
    return *temp_dir_ /
           testing::UnitTest::GetInstance()->current_test_info()->name();
  }

  QAction* Item() const {
    return window_->Window().findChild<QAction*>("structnerf_dense");
  }

  colmap::ModelViewerWidget* Viewer() const {
    return dynamic_cast<colmap::ModelViewerWidget*>(
        window_->Window().centralWidget());
  }

  QTabWidget* Tabs() const { return Find<QTabWidget>("tabs"); }

  template <typename Widget>
  Widget* Find(const char* name) const {
    auto* widget = window_->Window().findChild<Widget*>(name);
    EXPECT_NE(widget, nullptr) << name;
    return widget;
  }

  void Click(const char* name) {
    QTest::mouseClick(Find<QPushButton>(name), Qt::LeftButton);
  }

  // Opens the model and our window, and fills in the workspace.
  void OpenDialog(const std::string& room = "room") {
    window_->Window().ImportReconstruction(*temp_dir_ / (room + "/sparse/0"));
    ASSERT_TRUE(QTest::qWaitFor([this]() { return Item()->isEnabled(); }));
    Item()->trigger();
    ASSERT_TRUE(QTest::qWaitForWindowExposed(Tabs()->window()));
    Find<QLineEdit>("workspace_path")
        ->setText(QString::fromStdString(WorkspacePath()));
  }

  // As a user does, on the tab of advanced options.
  void SetNumSteps(const int num_steps) {
    Tabs()->setCurrentIndex(1);
    Find<QSpinBox>("num_steps")->setValue(num_steps);
    Tabs()->setCurrentIndex(0);
  }

  bool WaitForTraining() {
    return QTest::qWaitFor(
        [this]() {
          return Find<QLabel>("stage")->text() == "Training" &&
                 Find<QProgressBar>("bar")->value() > 0;
        },
        kRunMilliseconds);
  }

  const std::vector<CurvePoint>& Curve(const char* name) const {
    return dynamic_cast<CurveWidget*>(Find<QWidget>(name))->Curve();
  }

  // What COLMAP's log panel shows.
  QString Log() const {
    for (QWidget* widget : window_->Window().findChildren<QWidget*>()) {
      if (dynamic_cast<colmap::LogWidget*>(widget) != nullptr) {
        return widget->findChild<QPlainTextEdit*>()->toPlainText();
      }
    }
    return "";
  }

  // The button is enabled when the cloud has been read.
  bool WaitForCloud() {
    const auto* button = Find<QPushButton>("show_cloud");
    return QTest::qWaitFor([=]() { return button->isEnabled(); },
                           kRunMilliseconds);
  }

  bool WaitForTab(const int tab) {
    return QTest::qWaitFor(
        [this, tab]() { return Tabs()->currentIndex() == tab; },
        kRunMilliseconds);
  }

  // Whether COLMAP's own dense dialog finds maps of all images in a workspace.
  bool IsFusionOffered(const std::string& workspace_path) const {
    for (QWidget* widget : window_->Window().findChildren<QWidget*>()) {
      if (dynamic_cast<colmap::DenseReconstructionWidget*>(widget) == nullptr) {
        continue;
      }
      widget->findChild<QLineEdit*>(QString(), Qt::FindDirectChildrenOnly)
          ->setText(QString::fromStdString(workspace_path));
      QTest::qWait(200);
      for (const auto* button : widget->findChildren<QPushButton*>()) {
        if (button->text() == "Fusion") {
          return button->isEnabled();
        }
      }
    }
    ADD_FAILURE() << "COLMAP's dialog was not found";
    return false;
  }

  // Calls a function once there is a message box.
  void OnMessage(const std::function<void(QMessageBox*)>& function) {
    QTimer::singleShot(50, [this, function]() {
      auto* box = dynamic_cast<QMessageBox*>(QApplication::activeModalWidget());
      if (box == nullptr) {
        OnMessage(function);
      } else {
        function(box);
      }
    });
  }

  // Keeps what a message box says, with a picture of that name, and answers it.
  void Answer(QMessageBox* box,
              const QMessageBox::StandardButton button,
              const std::string& name) {
    message_ = box->text().toStdString();
    Screenshot(box, name);
    QTest::mouseClick(box->button(button), Qt::LeftButton);
  }

  // The next one.
  void AnswerMessage(const QMessageBox::StandardButton button,
                     const std::string& name) {
    OnMessage(
        [this, button, name](QMessageBox* box) { Answer(box, button, name); });
  }

  static void Screenshot(QWidget* window, const std::string& name) {
    window->raise();
    QTest::qWait(100);
    const QPoint corner = window->mapToGlobal(QPoint(0, 0));
    const QPixmap picture = window->screen()->grabWindow(
        0, corner.x(), corner.y(), window->width(), window->height());
    const std::string path =
        std::string(STRUCTNERF_SCREENSHOTS) + "/" + name + ".png";
    EXPECT_TRUE(picture.save(QString::fromStdString(path))) << path;
  }

  static std::unique_ptr<TempDir> temp_dir_;
  StructNerfOptions options_;
  std::unique_ptr<GuiWindow> window_;
  std::string message_;
};

std::unique_ptr<TempDir> DenseWindowTest::temp_dir_;

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

  // COLMAP enables this one exactly while its mapper runs.
  QAction* pause = nullptr;
  for (QAction* action : window_->Window().findChildren<QAction*>()) {
    if (action->text() == "Pause reconstruction") {
      pause = action;
    }
  }
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
}

TEST_F(DenseWindowTest, ATimeLimitChoosesTheQuality) {
  OpenDialog();
  auto* max_minutes = Find<QDoubleSpinBox>("max_minutes");
  EXPECT_EQ(max_minutes->value(), 0);
  max_minutes->setValue(1000);
  EXPECT_EQ(Find<QComboBox>("quality")->currentText(), "extreme");
  EXPECT_EQ(options_.quality, "extreme");
  EXPECT_EQ(options_.max_minutes, 1000);
  // Less than any machine needs.
  max_minutes->setValue(0.01);
  EXPECT_EQ(Find<QComboBox>("quality")->currentText(), "low");
  EXPECT_EQ(options_.reconstruction.training.num_steps,
            QualityPreset("low").training.num_steps);
  EXPECT_THAT(Find<QLabel>("expectation")->text().toStdString(),
              HasSubstr("about"));
}

TEST_F(DenseWindowTest, WordsKeepWhatWasChanged) {
  OpenDialog();
  SetNumSteps(7);
  const auto choose = [this](const char* name, const char* word) {
    auto* choice = Find<QComboBox>(name);
    choice->setCurrentText(word);
    emit choice->activated(choice->currentIndex());
  };
  choose("quality", "high");
  EXPECT_EQ(options_.reconstruction.training.num_steps, 7);
  EXPECT_EQ(options_.reconstruction.training.max_image_size,
            QualityPreset("high").training.max_image_size);
  choose("method", "nerf");
  EXPECT_EQ(options_.method, "nerf");
  EXPECT_EQ(options_.reconstruction.loss.patch_weight, 0);
  choose("method", "structnerf");
  EXPECT_EQ(options_.reconstruction.loss.patch_weight,
            QualityPreset("high").loss.patch_weight);
  Find<QDoubleSpinBox>("max_minutes")->setValue(0.01);
  EXPECT_EQ(options_.quality, "low");
  EXPECT_EQ(options_.reconstruction.training.num_steps, 7);
  EXPECT_EQ(options_.reconstruction.training.max_image_size,
            QualityPreset("low").training.max_image_size);
}

// COLMAP closes its model when another project is begun.
TEST_F(DenseWindowTest, RunsOnTheModelThatItShows) {
  OpenDialog();
  SetNumSteps(1000000);
  Viewer()->reconstruction = nullptr;
  Click("start");
  ASSERT_TRUE(WaitForTraining());
  Click("cancel");
  ASSERT_TRUE(WaitForTab(0));
}

// The others are over too soon to be caught on every machine.
TEST_F(DenseWindowTest, LongStagesAnswerAtOnce) {
  SyntheticRoomOptions room_options;
  room_options.num_views = 30;
  WriteSyntheticRoom(MakeSyntheticRoom(room_options), *temp_dir_ / "large");
  OpenDialog("large");
  Find<QLineEdit>("image_path")
      ->setText(QString::fromStdString(*temp_dir_ / "large/images"));
  const auto* bar = Find<QProgressBar>("bar");
  const auto* stage = Find<QLabel>("stage");
  for (const char* const name : {"Training", "Rendering depth maps"}) {
    SCOPED_TRACE(name);
    SetNumSteps(std::string(name) == "Training" ? 2000 : 20);
    Click("start");
    ASSERT_TRUE(QTest::qWaitFor(
        [&]() { return stage->text() == name && bar->value() > 0; },
        kRunMilliseconds));
    Click("pause");
    QTest::qWait(kAnswerMilliseconds);
    ASSERT_EQ(stage->text(), QString(name) + " (paused)");
    const int paused_value = bar->value();
    QTest::qWait(500);
    EXPECT_EQ(bar->value(), paused_value);

    QElapsedTimer timer;
    timer.start();
    Click("pause");
    EXPECT_TRUE(QTest::qWaitFor(
        [&]() { return bar->value() != paused_value || stage->text() != name; },
        kRunMilliseconds));
    EXPECT_LT(timer.elapsed(), kAnswerMilliseconds);

    timer.start();
    Click("cancel");
    ASSERT_TRUE(WaitForTab(0));
    EXPECT_LT(timer.elapsed(), kAnswerMilliseconds);
    EXPECT_FALSE(fs::exists(WorkspacePath()));
  }
}

TEST_F(DenseWindowTest, StopKeepsWhatWasLearned) {
  OpenDialog();
  SetNumSteps(1000000);
  Click("start");
  ASSERT_TRUE(WaitForTraining());
  QElapsedTimer timer;
  timer.start();
  Click("stop");
  EXPECT_FALSE(Find<QPushButton>("stop")->isEnabled());
  EXPECT_TRUE(QTest::qWaitFor(
      [this]() { return Find<QProgressBar>("bar")->value() == 1000; },
      kAnswerMilliseconds));
  EXPECT_LT(timer.elapsed(), kAnswerMilliseconds);
  ASSERT_TRUE(WaitForTab(3)) << message_;
  EXPECT_TRUE(fs::exists(WorkspacePath() + "/fused.ply"));
}

TEST_F(DenseWindowTest, CancelWritesNothing) {
  OpenDialog();
  SetNumSteps(1000000);
  Click("start");
  ASSERT_TRUE(WaitForTraining());
  QElapsedTimer timer;
  timer.start();
  Click("cancel");
  ASSERT_TRUE(WaitForTab(0));
  EXPECT_LT(timer.elapsed(), kAnswerMilliseconds);
  EXPECT_FALSE(fs::exists(WorkspacePath()));
  EXPECT_TRUE(Find<QPushButton>("start")->isEnabled());
}

TEST_F(DenseWindowTest, ClosingInTheMiddleAsks) {
  OpenDialog();
  SetNumSteps(1000000);
  Click("start");
  ASSERT_TRUE(WaitForTraining());
  AnswerMessage(QMessageBox::No, "message_close");
  EXPECT_FALSE(Tabs()->window()->close());
  EXPECT_THAT(message_, HasSubstr("has not ended"));
  EXPECT_EQ(Tabs()->currentIndex(), 2);
  AnswerMessage(QMessageBox::No, "message_close_main_window");
  EXPECT_FALSE(window_->Window().close());
  // Yes to our question, but no to COLMAP's own.
  OnMessage([this](QMessageBox* box) {
    Answer(box, QMessageBox::Yes, "message_close_main_window");
    AnswerMessage(QMessageBox::No, "message_quit");
  });
  EXPECT_FALSE(window_->Window().close());
  EXPECT_THAT(message_, HasSubstr("quit"));
  QTest::qWait(kAnswerMilliseconds);
  EXPECT_EQ(Tabs()->currentIndex(), 2);
  AnswerMessage(QMessageBox::Yes, "message_close");
  EXPECT_TRUE(Tabs()->window()->close());
  ASSERT_TRUE(WaitForTab(0));
  EXPECT_FALSE(fs::exists(WorkspacePath()));
}

TEST_F(DenseWindowTest, ClosingTheMainWindowCancels) {
  OpenDialog();
  SetNumSteps(1000000);
  Click("start");
  ASSERT_TRUE(WaitForTraining());
  OnMessage([this](QMessageBox* box) {
    Answer(box, QMessageBox::Yes, "message_close_main_window");
    // COLMAP's own question.
    AnswerMessage(QMessageBox::Yes, "message_quit");
  });
  EXPECT_TRUE(window_->Window().close());
  EXPECT_THAT(message_, HasSubstr("quit"));
  EXPECT_FALSE(window_->Window().isVisible());
  QElapsedTimer timer;
  timer.start();
  ASSERT_TRUE(WaitForTab(0));
  EXPECT_LT(timer.elapsed(), kAnswerMilliseconds);
  EXPECT_FALSE(fs::exists(WorkspacePath()));
}

TEST_F(DenseWindowTest, ARunMayEndWhileTheQuestionIsOpen) {
  OpenDialog();
  SetNumSteps(1000000);
  Click("start");
  ASSERT_TRUE(WaitForTraining());
  OnMessage([this](QMessageBox* box) {
    Click("stop");
    EXPECT_TRUE(WaitForTab(3));
    Answer(box, QMessageBox::Yes, "message_close");
  });
  EXPECT_TRUE(Tabs()->window()->close());
  EXPECT_TRUE(fs::exists(WorkspacePath() + "/fused.ply"));
}

TEST_F(DenseWindowTest, ABadFolderIsNamedInADialog) {
  OpenDialog();
  Find<QLineEdit>("image_path")->setText("/no/such/folder");
  EXPECT_EQ(Find<QComboBox>("device")->currentText(), "cpu");
  Find<QComboBox>("device")->setCurrentText("auto");
  AnswerMessage(QMessageBox::Ok, "message_bad_folder");
  Click("start");
  EXPECT_EQ(options_.device, "auto");
  ASSERT_TRUE(QTest::qWaitFor([this]() { return !message_.empty(); },
                              kRunMilliseconds));
  EXPECT_THAT(message_, HasSubstr("/no/such/folder"));
  EXPECT_FALSE(fs::exists(WorkspacePath()));

  message_.clear();
  Find<QLineEdit>("workspace_path")->clear();
  AnswerMessage(QMessageBox::Ok, "message_no_workspace");
  Click("start");
  EXPECT_THAT(message_, HasSubstr("workspace"));
}

}  // namespace
}  // namespace structnerf
