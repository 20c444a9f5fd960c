#pragma once

#include "colmap_plugin/structnerf_options.h"
#include "nerf/option_entry.h"

#include <string>
#include <vector>

#include <colmap/controllers/option_manager.h>

namespace structnerf {

// The preset of a method (nerf/methods.h) and a quality. Throws
// std::runtime_error naming the option if there is no such word.
ReconstructionOptions MakePreset(const std::string& method,
                                 const std::string& quality);

// Throws std::runtime_error if the words of the options are not those that the
// preset was made from: COLMAP's option manager takes abbreviated names.
void CheckPresetWords(const StructNerfOptions& options,
                      const std::string& method,
                      const std::string& quality);

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
