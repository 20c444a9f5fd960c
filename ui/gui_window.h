#pragma once

#include "colmap_plugin/structnerf_options.h"
#include "ui/colmap_link.h"
#include "ui/main_window_hook.h"

#include <functional>
#include <string>

#include <colmap/controllers/option_manager.h>
#include <colmap/ui/main_window.h>

namespace structnerf {

// COLMAP's main window with our item in its menu. Needs a QApplication.
class GuiWindow {
 public:
  // `options`: what the dialog starts from; must outlive this object.
  // `find_hook`: tests put a COLMAP of another kind in its place.
  GuiWindow(colmap::OptionManager manager,
            StructNerfOptions* options,
            const std::function<MainWindowHook(const QMainWindow&)>& find_hook =
                FindMainWindowHook);

  // With the model of a folder in it, if one is given. Says it, too, if the
  // item found no place.
  void Show(const std::string& import_path = "");

  colmap::MainWindow& Window() { return window_; }

 private:
  ColmapLink link_;  // the window's widgets use it until they are gone
  colmap::MainWindow window_;
  std::string error_;
};

}  // namespace structnerf
