#include "colmap_plugin/option_table.h"

#include "colmap_plugin/text_output.h"
#include "nerf/method_options.h"
#include "nerf/methods.h"

#include <stdexcept>
#include <utility>

namespace structnerf {
namespace {

constexpr double kMaxMinutes = 1e6;
constexpr double kMaxMemoryGb = 1e6;

std::string ValueText(const OptionValue& value) {
  if (const bool* flag = std::get_if<bool>(&value)) {
    return *flag ? "1" : "0";
  } else if (const int* integer = std::get_if<int>(&value)) {
    return std::to_string(*integer);
  } else if (const double* number = std::get_if<double>(&value)) {
    return FormatNumber("%g", *number);
  }
  return std::get<std::string>(value);
}

// e.g. "Training steps [1, 1e+08]".
std::string HelpText(const OptionEntry& entry) {
  if (entry.min_value == std::numeric_limits<double>::lowest() ||
      entry.max_value == std::numeric_limits<double>::max()) {
    return entry.help;
  }
  return entry.help + " [" + FormatNumber("%g", entry.min_value) + ", " +
         FormatNumber("%g", entry.max_value) + "]";
}

}  // namespace

std::vector<OptionEntry> MakeOptionTable(StructNerfOptions* options) {
  std::vector<OptionEntry> table = {
      {"StructNeRF.quality",
       &options->quality,
       "{low, medium, high, extreme, paper}; sets the defaults of the options "
       "below"},
      {"StructNeRF.method",
       &options->method,
       "{structnerf, nerf, dsnerf, dense_depth_prior, nerfing_mvs}; sets the "
       "defaults of the losses below"},
      {"StructNeRF.prior_path",
       &options->prior_path,
       "Folder of depth maps in COLMAP's format, or a TorchScript module that "
       "predicts them, for the methods that need a depth prior"},
      {"StructNeRF.prior_type",
       &options->prior_type,
       "Which maps of that folder {geometric, photometric}"},
      {"StructNeRF.export_path",
       &options->export_path,
       "File that the scene is written to before training, for "
       "structnerf_train or to report a fault"},
      {"StructNeRF.max_memory_gb",
       &options->max_memory_gb,
       "Memory to stay within; -1 = three quarters of the machine's"},
      {"StructNeRF.max_minutes",
       &options->max_minutes,
       "Minutes that the run may take; chooses the quality, unless that is "
       "given, and shortens the training to fit; 0 = no limit",
       0,
       kMaxMinutes},
      {"StructNeRF.checkpoint_minutes",
       &options->checkpoint_minutes,
       "Minutes between two checkpoints that a killed run goes on from; 0 = "
       "none",
       0,
       kMaxMinutes},
      {"StructNeRF.resume",
       &options->resume,
       "Go on with a run that was killed; 0 = remove it and start anew"},
      {"StructNeRF.input_type",
       &options->input_type,
       "Maps that are fused {geometric, photometric}; "
       "StereoFusion.min_num_pixels 0 is chosen from the number of views"},
      {"StructNeRF.device",
       &options->device,
       "Where the field is trained and rendered {auto, cpu, cuda}; auto = an "
       "NVIDIA card if there is one"}};
  const auto entries = MakeMethodOptionEntries(&options->reconstruction);
  table.insert(table.end(), entries.begin(), entries.end());
  return table;
}

ReconstructionOptions MakePreset(const std::string& method,
                                 const std::string& quality) {
  try {
    return ApplyMethod(method, QualityPreset(quality));
  } catch (const std::invalid_argument& error) {
    throw std::runtime_error(std::string("The option --StructNeRF.") +
                             error.what() + ".");
  }
}

void CheckPresetWords(const StructNerfOptions& options,
                      const std::string& method,
                      const std::string& quality) {
  if (options.method != method || options.quality != quality) {
    throw std::runtime_error(
        "Write --StructNeRF.method and --StructNeRF.quality out; they decide "
        "what the other options start from.");
  }
}

void AddOptions(const std::vector<OptionEntry>& table,
                colmap::OptionManager* manager) {
  for (const OptionEntry& entry : table) {
    std::visit(
        [&](auto* pointer) {
          manager->AddDefaultOption(entry.name, pointer, HelpText(entry));
        },
        entry.value);
  }
}

void CheckOptions(const StructNerfOptions& options) {
  const std::string error = FindMethodOptionError(options.reconstruction);
  if (!error.empty()) {
    throw std::runtime_error("The option --" + error + ".");
  }
  for (const auto& [name, minutes] :
       {std::pair("checkpoint_minutes", options.checkpoint_minutes),
        std::pair("max_minutes", options.max_minutes)}) {
    if (!(minutes >= 0 && minutes <= kMaxMinutes)) {
      throw std::runtime_error(std::string("The option --StructNeRF.") + name +
                               " must be between 0 and " +
                               FormatNumber("%g", kMaxMinutes) + ", but is " +
                               FormatNumber("%g", minutes) + ".");
    }
  }
  const double max_memory_gb = options.max_memory_gb;
  if (max_memory_gb != -1 &&
      !(max_memory_gb > 0 && max_memory_gb <= kMaxMemoryGb)) {
    throw std::runtime_error(
        "The option --StructNeRF.max_memory_gb must be more than 0 and at "
        "most " +
        FormatNumber("%g", kMaxMemoryGb) +
        ", or -1 for three quarters of the machine's, but is " +
        FormatNumber("%g", max_memory_gb) + ".");
  }
  for (const auto& [name, type] :
       {std::pair("input_type", options.input_type),
        std::pair("prior_type", options.prior_type)}) {
    if (type != "geometric" && type != "photometric") {
      throw std::runtime_error(std::string("The option --StructNeRF.") + name +
                               " must be geometric or photometric, but is " +
                               type + ".");
    }
  }
  if (options.reconstruction.NeedsPrior() && options.prior_path.empty()) {
    throw std::runtime_error(
        "The option --StructNeRF.prior_path is missing: the method " +
        options.method +
        " with these options needs a depth prior, a folder of depth maps or a "
        "TorchScript module.");
  }
  if (!options.reconstruction.NeedsPrior() && !options.prior_path.empty()) {
    throw std::runtime_error(
        "The option --StructNeRF.prior_path is given, but nothing uses it; "
        "choose --StructNeRF.method dense_depth_prior or nerfing_mvs, or set "
        "--StructNeRF.dense_prior_weight.");
  }
}

std::string OptionText(const OptionEntry& entry) {
  return entry.name + " = " + ValueText(entry.Value());
}

}  // namespace structnerf
