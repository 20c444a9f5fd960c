#pragma once

#include "colmap_plugin/structnerf_options.h"
#include "ui/colmap_link.h"

#include <string>

#include <colmap/controllers/option_manager.h>
#include <colmap/ui/main_window.h>

namespace structnerf {

// COLMAP's main window with our item in its menu. Needs a QApplication.
class GuiWindow {
 public:
  // `options`: what the dialog starts from; must outlive this object.
  GuiWindow(colmap::OptionManager manager, StructNerfOptions* options);

  // Says it, too, if the item found no place.
  void Show();

  colmap::MainWindow& Window() { return window_; }

 private:
  ColmapLink link_;  // the window's widgets use it until they are gone
  colmap::MainWindow window_;
  std::string error_;
};

}  // namespace structnerf
