#include "ui/option_page.h"

#include <algorithm>
#include <string>

namespace structnerf {
namespace {

// Widgets are as wide as their largest number.
constexpr double kLargestNumber = 1e9;
constexpr double kStep = 0.01;
constexpr int kDecimals = 6;

// "StructNeRF.num_steps" -> "num_steps".
std::string Label(const std::string& name) {
  return name.substr(name.find('.') + 1);
}

}  // namespace

OptionPage::OptionPage(const std::vector<OptionEntry>& entries, QWidget* parent)
    : OptionsWidget(parent) {
  setWindowFlags(Qt::Widget);
  for (const OptionEntry& entry : entries) {
    const std::string label = Label(entry.name);
    const double min_value = std::max(entry.min_value, -kLargestNumber);
    const double max_value = std::min(entry.max_value, kLargestNumber);
    QWidget* widget = nullptr;
    if (auto* const* flag = std::get_if<bool*>(&entry.value)) {
      widget = AddOptionBool(*flag, label);
    } else if (auto* const* integer = std::get_if<int*>(&entry.value)) {
      widget = AddOptionInt(*integer,
                            label,
                            static_cast<int>(min_value),
                            static_cast<int>(max_value));
    } else if (auto* const* number = std::get_if<double*>(&entry.value)) {
      widget = AddOptionDouble(
          *number, label, min_value, max_value, kStep, kDecimals);
    } else {
      widget = AddOptionText(std::get<std::string*>(entry.value), label);
    }
    widget->setObjectName(QString::fromStdString(label));
    widget->setToolTip(QString::fromStdString(entry.help));
  }
}

}  // namespace structnerf
