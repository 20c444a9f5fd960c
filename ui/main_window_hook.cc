#include "ui/main_window_hook.h"

#include <QMenuBar>

namespace structnerf {
namespace {

// Without the mark of its shortcut.
QString PlainTitle(QString title) { return title.remove('&'); }

QMenu* FindMenu(const QMainWindow& window, const QString& title) {
  // The menu bar is made when it is asked for, which takes a non-const window.
  const auto* menu_bar =
      window.findChild<QMenuBar*>(QString(), Qt::FindDirectChildrenOnly);
  if (menu_bar == nullptr) {
    return nullptr;
  }
  for (const QAction* action : menu_bar->actions()) {
    if (action->menu() != nullptr &&
        PlainTitle(action->menu()->title()) == title) {
      return action->menu();
    }
  }
  return nullptr;
}

QAction* FindAction(const QMenu& menu, const QString& text) {
  for (QAction* action : menu.actions()) {
    if (PlainTitle(action->text()) == text) {
      return action;
    }
  }
  return nullptr;
}

}  // namespace

MainWindowHook FindMainWindowHook(const QMainWindow& window) {
  MainWindowHook hook;
  hook.viewer =
      dynamic_cast<colmap::ModelViewerWidget*>(window.centralWidget());
  hook.reconstruction_menu = FindMenu(window, "Reconstruction");
  std::string missing;
  if (hook.reconstruction_menu == nullptr) {
    missing = "menu \"Reconstruction\"";
  } else {
    hook.dense_action =
        FindAction(*hook.reconstruction_menu, "Dense reconstruction");
    hook.pause_action =
        FindAction(*hook.reconstruction_menu, "Pause reconstruction");
    if (hook.dense_action == nullptr) {
      missing = "item \"Dense reconstruction\"";
    } else if (hook.pause_action == nullptr) {
      missing = "item \"Pause reconstruction\"";
    }
  }
  if (hook.viewer == nullptr) {
    missing = "viewer of models";
  }
  if (!missing.empty()) {
    hook.error =
        "StructNeRF dense reconstruction is not available in this "
        "window, because this version of COLMAP has no " +
        missing + " where it is expected; use the command structnerf_dense.";
  }
  return hook;
}

}  // namespace structnerf
