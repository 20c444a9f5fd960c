#pragma once

#include "colmap_plugin/structnerf_options.h"
#include "tests/support/temp_dir.h"
#include "ui/curve_widget.h"
#include "ui/gui_window.h"

#include <QMessageBox>
#include <QString>
#include <QTabWidget>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

class QAction;

namespace structnerf {

constexpr int kAnswerMilliseconds = 1000;
constexpr int kRunMilliseconds = 300000;

// COLMAP's window with ours, and a small room to run on.
class DenseWindowFixture : public testing::Test {
 protected:
  static void SetUpTestSuite();
  static void TearDownTestSuite();

  DenseWindowFixture();

  // A folder of this test's own that does not exist yet.
  static std::string WorkspacePath();

  QAction* Item() const;

  // COLMAP's, which tells whether its mapper runs.
  QAction* PauseAction() const;
  colmap::ModelViewerWidget* Viewer() const;
  QTabWidget* Tabs() const { return Find<QTabWidget>("tabs"); }

  template <typename Widget>
  Widget* Find(const char* name) const {
    auto* widget = window_->Window().findChild<Widget*>(name);
    EXPECT_NE(widget, nullptr) << name;
    return widget;
  }

  void Click(const char* name);

  // Opens the model and our window, and fills in the workspace.
  void OpenDialog(const std::string& room = "room");

  // As a user does, on the tab of advanced options.
  void SetNumSteps(int num_steps);

  bool WaitForTraining();

  // The button is enabled when the cloud has been read.
  bool WaitForCloud();

  bool WaitForTab(int tab);

  const std::vector<CurvePoint>& Curve(const char* name) const;

  // What COLMAP's log panel shows.
  QString Log() const;

  // Whether COLMAP's own dense dialog finds maps of all images in a workspace.
  bool IsFusionOffered(const std::string& workspace_path) const;

  // Calls a function once there is a message box.
  void OnMessage(const std::function<void(QMessageBox*)>& function);

  // Keeps what a message box says, with a picture of that name, and answers it.
  void Answer(QMessageBox* box,
              QMessageBox::StandardButton button,
              const std::string& name);

  // The next one.
  void AnswerMessage(QMessageBox::StandardButton button,
                     const std::string& name);

  static void Screenshot(QWidget* window, const std::string& name);

  static std::unique_ptr<TempDir> temp_dir_;
  StructNerfOptions options_;

  // Of the project.
  decltype(colmap::OptionManager::image_path) image_path_;

  std::unique_ptr<GuiWindow> window_;
  std::string message_;
};

}  // namespace structnerf
