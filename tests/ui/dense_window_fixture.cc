#include "tests/ui/dense_window_fixture.h"

#include "tests/support/synthetic_room.h"
#include "tests/support/synthetic_room_writer.h"

#include <QAction>
#include <QApplication>
#include <QLabel>
#include <QLineEdit>
#include <QPlainTextEdit>
#include <QProgressBar>
#include <QPushButton>
#include <QScreen>
#include <QSpinBox>
#include <QTest>
#include <QTimer>
#include <utility>

namespace structnerf {

std::unique_ptr<TempDir> DenseWindowFixture::temp_dir_;

void DenseWindowFixture::SetUpTestSuite() {
  temp_dir_ = std::make_unique<TempDir>();
  SyntheticRoomOptions room_options;
  room_options.num_views = 8;
  room_options.width = 160;
  room_options.height = 120;
  WriteSyntheticRoom(MakeSyntheticRoom(room_options), *temp_dir_ / "room");
}

void DenseWindowFixture::TearDownTestSuite() { temp_dir_.reset(); }

DenseWindowFixture::DenseWindowFixture() {
  options_.quality = "low";
  options_.reconstruction = QualityPreset("low");
  colmap::OptionManager manager;
  image_path_ = manager.image_path;
  *image_path_ = *temp_dir_ / "room/images";
  window_ = std::make_unique<GuiWindow>(std::move(manager), &options_);
  window_->Show();
  EXPECT_TRUE(QTest::qWaitForWindowExposed(&window_->Window()));
}

std::string DenseWindowFixture::WorkspacePath() {
  return *temp_dir_ /
         testing::UnitTest::GetInstance()->current_test_info()->name();
}

QAction* DenseWindowFixture::Item() const {
  return window_->Window().findChild<QAction*>("structnerf_dense");
}

QAction* DenseWindowFixture::PauseAction() const {
  for (QAction* action : window_->Window().findChildren<QAction*>()) {
    if (action->text() == "Pause reconstruction") {
      return action;
    }
  }
  ADD_FAILURE() << "COLMAP's action was not found";
  return nullptr;
}

colmap::ModelViewerWidget* DenseWindowFixture::Viewer() const {
  return dynamic_cast<colmap::ModelViewerWidget*>(
      window_->Window().centralWidget());
}

void DenseWindowFixture::Click(const char* name) {
  QTest::mouseClick(Find<QPushButton>(name), Qt::LeftButton);
}

void DenseWindowFixture::OpenDialog(const std::string& room) {
  window_->Window().ImportReconstruction(*temp_dir_ / (room + "/sparse/0"));
  ASSERT_TRUE(QTest::qWaitFor([this]() { return Item()->isEnabled(); }));
  Item()->trigger();
  ASSERT_TRUE(QTest::qWaitForWindowExposed(Tabs()->window()));
  Find<QLineEdit>("workspace_path")
      ->setText(QString::fromStdString(WorkspacePath()));
}

void DenseWindowFixture::SetNumSteps(const int num_steps) {
  Tabs()->setCurrentIndex(1);
  Find<QSpinBox>("num_steps")->setValue(num_steps);
  Tabs()->setCurrentIndex(0);
}

bool DenseWindowFixture::WaitForTraining() {
  return QTest::qWaitFor(
      [this]() {
        return Find<QLabel>("stage")->text() == "Training" &&
               Find<QProgressBar>("bar")->value() > 0;
      },
      kRunMilliseconds);
}

bool DenseWindowFixture::WaitForCloud() {
  const auto* button = Find<QPushButton>("show_cloud");
  return QTest::qWaitFor([=]() { return button->isEnabled(); },
                         kRunMilliseconds);
}

bool DenseWindowFixture::WaitForTab(const int tab) {
  return QTest::qWaitFor(
      [this, tab]() { return Tabs()->currentIndex() == tab; },
      kRunMilliseconds);
}

const std::vector<CurvePoint>& DenseWindowFixture::Curve(
    const char* name) const {
  return dynamic_cast<CurveWidget*>(Find<QWidget>(name))->Curve();
}

QString DenseWindowFixture::Log() const {
  for (QWidget* widget : window_->Window().findChildren<QWidget*>()) {
    if (dynamic_cast<colmap::LogWidget*>(widget) != nullptr) {
      return widget->findChild<QPlainTextEdit*>()->toPlainText();
    }
  }
  return "";
}

bool DenseWindowFixture::IsFusionOffered(
    const std::string& workspace_path) const {
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

void DenseWindowFixture::OnMessage(
    const std::function<void(QMessageBox*)>& function) {
  QTimer::singleShot(50, [this, function]() {
    auto* box = dynamic_cast<QMessageBox*>(QApplication::activeModalWidget());
    if (box == nullptr) {
      OnMessage(function);
    } else {
      function(box);
    }
  });
}

void DenseWindowFixture::Answer(QMessageBox* box,
                                const QMessageBox::StandardButton button,
                                const std::string& name) {
  message_ = box->text().toStdString();
  Screenshot(box, name);
  QTest::mouseClick(box->button(button), Qt::LeftButton);
}

void DenseWindowFixture::AnswerMessage(const QMessageBox::StandardButton button,
                                       const std::string& name) {
  OnMessage(
      [this, button, name](QMessageBox* box) { Answer(box, button, name); });
}

void DenseWindowFixture::Screenshot(QWidget* window, const std::string& name) {
  window->raise();
  QTest::qWait(100);
  const QPoint corner = window->mapToGlobal(QPoint(0, 0));
  const QPixmap picture = window->screen()->grabWindow(
      0, corner.x(), corner.y(), window->width(), window->height());
  const std::string path =
      std::string(STRUCTNERF_SCREENSHOTS) + "/" + name + ".png";
  EXPECT_TRUE(picture.save(QString::fromStdString(path))) << path;
}

}  // namespace structnerf
