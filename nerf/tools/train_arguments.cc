#include "nerf/tools/train_arguments.h"

#include "nerf/engine/devices.h"
#include "nerf/method_options.h"
#include "nerf/methods.h"

#include <algorithm>
#include <charconv>
#include <map>
#include <sstream>
#include <stdexcept>
#include <type_traits>
#include <utility>

namespace structnerf {
namespace {

// What has been decided when the scene was exported.
bool IsOfScene(const OptionEntry& entry) {
  return entry.name == "StructNeRF.max_image_size" ||
         entry.name == "StructNeRF.planar_min_area";
}

std::vector<OptionEntry> MakeEntries(ReconstructionOptions* options) {
  auto entries = MakeMethodOptionEntries(options);
  entries.erase(std::remove_if(entries.begin(), entries.end(), IsOfScene),
                entries.end());
  return entries;
}

using NamedValues = std::vector<std::pair<std::string, std::string>>;

NamedValues SplitArguments(const std::vector<std::string>& arguments) {
  NamedValues values;
  for (size_t i = 0; i < arguments.size(); ++i) {
    const std::string& argument = arguments[i];
    if (argument.rfind("--", 0) != 0) {
      throw std::invalid_argument("The argument " + argument +
                                  " belongs to no option.");
    }
    const size_t equals = argument.find('=');
    if (equals != std::string::npos) {
      values.emplace_back(argument.substr(2, equals - 2),
                          argument.substr(equals + 1));
    } else if (i + 1 < arguments.size()) {
      values.emplace_back(argument.substr(2), arguments[++i]);
    } else {
      throw std::invalid_argument("The option " + argument + " needs a value.");
    }
  }
  return values;
}

template <typename T>
bool Parse(const std::string& text, T* value) {
  if constexpr (std::is_same_v<T, std::string>) {
    *value = text;
    return true;
  } else if constexpr (std::is_same_v<T, bool>) {
    *value = text == "1";
    return text == "0" || text == "1";
  } else {
    const char* const end = text.data() + text.size();
    const auto [rest, error] = std::from_chars(text.data(), end, *value);
    return error == std::errc() && rest == end;
  }
}

// Sets an option of `entries`; false if there is none of this name.
bool SetOption(const std::vector<OptionEntry>& entries,
               const std::string& name,
               const std::string& text) {
  const auto entry = std::find_if(
      entries.begin(), entries.end(), [&](const OptionEntry& candidate) {
        return candidate.name == name;
      });
  if (entry == entries.end()) {
    return false;
  }
  if (!std::visit([&](auto* value) { return Parse(text, value); },
                  entry->value)) {
    throw std::invalid_argument("The value of --" + name +
                                " cannot be read: " + text + ".");
  }
  return true;
}

}  // namespace

TrainArguments ParseTrainArguments(const std::vector<std::string>& arguments) {
  const NamedValues values = SplitArguments(arguments);
  TrainArguments result;
  const std::map<std::string, std::string*> texts = {
      {"scene_path", &result.scene_path},
      {"output_path", &result.output_path},
      {"StructNeRF.quality", &result.quality},
      {"StructNeRF.method", &result.method},
      {"StructNeRF.device", &result.device}};
  for (const auto& [name, value] : values) {
    if (const auto text = texts.find(name); text != texts.end()) {
      *text->second = value;
    }
  }
  for (const char* name : {"scene_path", "output_path"}) {
    if (texts.at(name)->empty()) {
      throw std::invalid_argument(std::string("The option --") + name +
                                  " is missing; --help explains it.");
    }
  }
  try {
    result.options = ApplyMethod(result.method, QualityPreset(result.quality));
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(std::string("The option --StructNeRF.") +
                                error.what() + ".");
  }
  const auto entries = MakeEntries(&result.options);
  for (const auto& [name, value] : values) {
    if (texts.count(name) == 0 && !SetOption(entries, name, value)) {
      throw std::invalid_argument("There is no option --" + name +
                                  "; --help lists them.");
    }
  }
  const std::string error = FindMethodOptionError(result.options);
  if (!error.empty()) {
    throw std::invalid_argument("The option --" + error + ".");
  }
  result.device = ResolveDevice(result.device, result.options.field.type);
  return result;
}

std::string TrainUsage() {
  std::ostringstream usage;
  usage << "structnerf_train --scene_path FILE --output_path FOLDER "
           "[--option VALUE]...\n"
           "Trains on a scene that structnerf_dense has written "
           "(--StructNeRF.export_path) and\nwrites its maps into a new folder, "
           "in COLMAP's formats.\n"
           "  --StructNeRF.quality   {low, medium, high, extreme, paper} "
           "(medium)\n"
           "  --StructNeRF.method    {structnerf, nerf, dsnerf, "
           "dense_depth_prior, nerfing_mvs}\n"
           "                         (structnerf)\n"
           "  --StructNeRF.device    {auto, cpu, cuda} (cpu)\n"
           "and the options of the method, with the defaults of medium:\n";
  ReconstructionOptions options = QualityPreset("medium");
  for (const OptionEntry& entry : MakeEntries(&options)) {
    usage << "  --" << entry.name << "  " << entry.help << " (";
    std::visit([&](const auto* value) { usage << *value; }, entry.value);
    usage << ")\n";
  }
  return usage.str();
}

}  // namespace structnerf
