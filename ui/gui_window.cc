#include "ui/gui_window.h"

#include "ui/dense_action.h"

#include <QMessageBox>
#include <utility>

#include <glog/logging.h>

namespace structnerf {

GuiWindow::GuiWindow(
    colmap::OptionManager manager,
    StructNerfOptions* options,
    const std::function<MainWindowHook(const QMainWindow&)>& find_hook)
    : link_(manager), window_(std::move(manager)) {
  const MainWindowHook hook = find_hook(window_);
  error_ = hook.error;
  if (error_.empty()) {
    link_.SetViewer(hook.viewer);
    link_.SetPauseAction(hook.pause_action);
    new DenseAction(&window_, hook, options, &link_);
  }
}

void GuiWindow::Show(const std::string& import_path) {
  window_.show();
  if (!import_path.empty()) {
    window_.ImportReconstruction(import_path);
  }
  if (!error_.empty()) {
    LOG(WARNING) << error_;
    auto* box = new QMessageBox(QMessageBox::Warning,
                                "",
                                QString::fromStdString(error_),
                                QMessageBox::Ok,
                                &window_);
    box->setAttribute(Qt::WA_DeleteOnClose);
    box->open();
  }
}

}  // namespace structnerf
