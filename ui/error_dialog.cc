#include "ui/error_dialog.h"

#include <QMessageBox>
#include <exception>

#include <glog/logging.h>

namespace structnerf {

void ShowError(QWidget* parent, const std::string& sentence) {
  LOG(ERROR) << sentence;
  QMessageBox::critical(parent, "", QString::fromStdString(sentence));
}

void ShowErrorOf(QWidget* parent, const std::function<void()>& function) {
  try {
    function();
  } catch (const std::exception& error) {
    ShowError(parent, error.what());
  }
}

}  // namespace structnerf
