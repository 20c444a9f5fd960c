#pragma once

#include <QAction>
#include <QMainWindow>
#include <QMenu>
#include <string>

#include <colmap/ui/model_viewer_widget.h>

namespace structnerf {

// What we need of COLMAP's main window, found from outside: its members are
// private, but its widgets are children of it.
struct MainWindowHook {
  QMenu* reconstruction_menu = nullptr;
  QAction* dense_action = nullptr;  // COLMAP's own, which ours stands beside

  // Enabled while the mapper runs, until it is told to pause; it then ends the
  // image that it is at.
  QAction* pause_action = nullptr;

  colmap::ModelViewerWidget* viewer = nullptr;

  // One sentence saying what a COLMAP of another kind lacks; empty if nothing.
  std::string error;
};

MainWindowHook FindMainWindowHook(const QMainWindow& window);

}  // namespace structnerf
