#pragma once

#include "colmap_plugin/structnerf_options.h"

#include <limits>
#include <string>
#include <variant>
#include <vector>

#include <colmap/controllers/option_manager.h>

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

  OptionValue Value() const;
};

// All --StructNeRF.* options. The entries point into `options`.
std::vector<OptionEntry> MakeOptionTable(StructNerfOptions* options);

// Registers the table with COLMAP's option manager; the present values are the
// defaults.
void AddOptions(const std::vector<OptionEntry>& table,
                colmap::OptionManager* manager);

// Throws std::runtime_error naming the first option that is out of its range.
void CheckOptions(const StructNerfOptions& options);

// "name = value", as in a project file.
std::string OptionText(const OptionEntry& entry);

}  // namespace structnerf
