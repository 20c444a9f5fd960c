#include "ui/folder_edit.h"

#include <QFileDialog>
#include <QPushButton>

namespace structnerf {

QLineEdit* AddFolderEdit(const char* name, QWidget* parent, QBoxLayout* row) {
  auto* path = new QLineEdit(parent);
  path->setObjectName(name);
  auto* button = new QPushButton("Select folder", parent);
  QObject::connect(button, &QPushButton::clicked, parent, [parent, path]() {
    const QString folder = QFileDialog::getExistingDirectory(
        parent, "Select folder", path->text());
    if (!folder.isEmpty()) {
      path->setText(folder);
    }
  });
  row->addWidget(path, 1);
  row->addWidget(button);
  return path;
}

}  // namespace structnerf
