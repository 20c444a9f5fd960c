#pragma once

#include "colmap_plugin/structnerf_options.h"
#include "ui/colmap_link.h"
#include "ui/dense_widget.h"
#include "ui/main_window_hook.h"

#include <QAction>
#include <QMainWindow>

namespace structnerf {

// The item "StructNeRF dense reconstruction" in COLMAP's menu and tool bar.
// Enabled while a model with at least two registered images is shown and the
// mapper does not run.
class DenseAction : public QAction {
 public:
  // A child of the window. `hook` has no error; `options` and `link` must
  // outlive the window.
  DenseAction(QMainWindow* window,
              const MainWindowHook& hook,
              StructNerfOptions* options,
              ColmapLink* link);

 private:
  void UpdateEnabled();

  ColmapLink* const link_;
  DenseWidget* const widget_;
};

}  // namespace structnerf
