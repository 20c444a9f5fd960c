// Runs tests that open windows. COLMAP wants its logging first.

#include "colmap_plugin/colmap_compat.h"
#include "ui/gui_command.h"

#include <QApplication>

#include <gtest/gtest.h>

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  structnerf::InitializeColmap(argv);
  structnerf::InitializeGuiResources();
  QApplication app(argc, argv);
  return RUN_ALL_TESTS();
}
