#include "ui/error_dialog.h"

#include "colmap_plugin/error_text.h"

#include <QMessageBox>

#include <glog/logging.h>

namespace structnerf {

void ShowError(QWidget* parent, const std::string& sentence) {
  LOG(ERROR) << sentence;
  QMessageBox::critical(parent, "", QString::fromStdString(sentence));
}

void ShowErrorOf(QWidget* parent, const std::function<void()>& function) {
  try {
    function();
  } catch (...) {
    ShowError(parent, CurrentErrorText());
  }
}

}  // namespace structnerf
