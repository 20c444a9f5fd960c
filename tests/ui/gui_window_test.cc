#include "ui/gui_window.h"

#include <QMessageBox>
#include <QTest>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace structnerf {
namespace {

using testing::HasSubstr;

TEST(GuiWindow, OpensWithoutAPlaceForTheItemAndSaysSo) {
  StructNerfOptions options;
  GuiWindow window(colmap::OptionManager(), &options, [](const QMainWindow&) {
    return FindMainWindowHook(QMainWindow());
  });
  window.Show();
  EXPECT_TRUE(QTest::qWaitForWindowExposed(&window.Window()));
  EXPECT_EQ(window.Window().findChild<QAction*>("structnerf_dense"), nullptr);
  const auto* box = window.Window().findChild<QMessageBox*>();
  ASSERT_NE(box, nullptr);
  EXPECT_TRUE(box->isVisible());
  EXPECT_THAT(box->text().toStdString(), HasSubstr("is not available"));
}

}  // namespace
}  // namespace structnerf
