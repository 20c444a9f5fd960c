#include "ui/main_window_hook.h"

#include <QMenuBar>
#include <string>

#include <colmap/ui/main_window.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace structnerf {
namespace {

using testing::HasSubstr;

TEST(MainWindowHook, FindsEverythingInColmap) {
  const colmap::MainWindow window{colmap::OptionManager()};
  const MainWindowHook hook = FindMainWindowHook(window);
  EXPECT_EQ(hook.error, "");
  ASSERT_NE(hook.reconstruction_menu, nullptr);
  ASSERT_NE(hook.dense_action, nullptr);
  EXPECT_EQ(hook.dense_action->text(), "Dense reconstruction");
  ASSERT_NE(hook.pause_action, nullptr);
  EXPECT_FALSE(hook.pause_action->isEnabled());
  EXPECT_NE(hook.viewer, nullptr);
}

TEST(MainWindowHook, SaysWhatIsMissing) {
  colmap::OptionManager manager;
  QMainWindow window;
  window.setCentralWidget(new colmap::ModelViewerWidget(&window, &manager));
  EXPECT_THAT(FindMainWindowHook(window).error,
              HasSubstr("menu \"Reconstruction\""));
  QMenu* menu = window.menuBar()->addMenu("&Reconstruction");
  EXPECT_THAT(FindMainWindowHook(window).error,
              HasSubstr("item \"Dense reconstruction\""));
  menu->addAction("Dense reconstruction");
  EXPECT_THAT(FindMainWindowHook(window).error,
              HasSubstr("item \"Pause reconstruction\""));
  menu->addAction("Pause reconstruction");
  EXPECT_EQ(FindMainWindowHook(window).error, "");
  window.setCentralWidget(new QWidget(&window));
  EXPECT_THAT(FindMainWindowHook(window).error, HasSubstr("viewer of models"));
}

}  // namespace
}  // namespace structnerf
