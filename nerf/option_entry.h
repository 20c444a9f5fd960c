#pragma once

#include <limits>
#include <string>
#include <variant>

namespace structnerf {

using OptionValue = std::variant<bool, int, double, std::string>;

// One option of the method, for the command line, project files, the report
// and user interfaces alike.
struct OptionEntry {
  std::string name;  // e.g. "StructNeRF.num_steps"
  std::variant<bool*, int*, double*, std::string*> value;
  std::string help;

  // Inclusive, for int and double only; those of
  // ReconstructionOptions::Check().
  double min_value = std::numeric_limits<double>::lowest();
  double max_value = std::numeric_limits<double>::max();

  OptionValue Value() const {
    return std::visit([](const auto* pointer) { return OptionValue(*pointer); },
                      value);
  }
};

}  // namespace structnerf
