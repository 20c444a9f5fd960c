#pragma once

#include <QWidget>
#include <functional>
#include <string>

namespace structnerf {

// One sentence about what went wrong, in a dialog and in COLMAP's log.
void ShowError(QWidget* parent, const std::string& sentence);

// Calls a function and shows what it throws.
void ShowErrorOf(QWidget* parent, const std::function<void()>& function);

}  // namespace structnerf
