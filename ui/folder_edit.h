#pragma once

#include <QBoxLayout>
#include <QLineEdit>

namespace structnerf {

// Adds a line for the path of a folder to a row, and a button that lets one
// select it.
QLineEdit* AddFolderEdit(const char* name, QWidget* parent, QBoxLayout* row);

}  // namespace structnerf
