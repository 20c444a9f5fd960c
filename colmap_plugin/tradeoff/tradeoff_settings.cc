#include "colmap_plugin/tradeoff/tradeoff_settings.h"

#include <algorithm>
#include <cctype>
#include <sstream>
#include <stdexcept>

namespace structnerf {
namespace {

constexpr char kSection[] = "StructNeRF.";

// What every run is told by the command itself.
const std::vector<std::string> kReserved = {"StructNeRF.seed",
                                            "StructNeRF.print_options",
                                            "StructNeRF.resume",
                                            "StructNeRF.test_every"};

[[noreturn]] void ThrowWrong(const std::string& part,
                             const std::string& reason) {
  throw std::runtime_error("The option --settings has \"" + part + "\", " +
                           reason + ".");
}

TradeoffSetting ParseSetting(const std::string& text) {
  TradeoffSetting setting;
  std::istringstream stream(text);
  for (std::string part; stream >> part;) {
    const size_t equals = part.find('=');
    if (equals == 0 || equals == std::string::npos ||
        equals + 1 == part.size()) {
      ThrowWrong(part, "which is not of the form name=value");
    }
    std::string name = part.substr(0, equals);
    if (name.find('.') == std::string::npos) {
      name.insert(0, kSection);
    }
    if (std::count(kReserved.begin(), kReserved.end(), name) > 0) {
      ThrowWrong(part, "which the command sets itself; leave it out");
    }
    setting.name += (setting.name.empty() ? "" : " ") + part;
    setting.arguments.push_back("--" + name + part.substr(equals));
  }
  return setting;
}

}  // namespace

std::string TradeoffSetting::FolderName() const {
  std::string folder = name;
  std::replace_if(
      folder.begin(),
      folder.end(),
      [](const unsigned char c) {
        return std::isalnum(c) == 0 && c != '=' && c != '.' && c != '-' &&
               c != '_';
      },
      '+');
  return folder;
}

std::vector<TradeoffSetting> ParseTradeoffSettings(const std::string& text) {
  std::vector<TradeoffSetting> settings;
  std::istringstream stream(text);
  for (std::string part; std::getline(stream, part, ',');) {
    TradeoffSetting setting = ParseSetting(part);
    if (setting.name.empty()) {
      ThrowWrong(text, "where nothing stands between two commas");
    }
    for (const TradeoffSetting& other : settings) {
      if (other.FolderName() == setting.FolderName()) {
        ThrowWrong(setting.name, "which is there twice");
      }
    }
    settings.push_back(std::move(setting));
  }
  if (settings.empty()) {
    throw std::runtime_error(
        "The option --settings is empty; give for example \"quality=low, "
        "quality=medium\".");
  }
  return settings;
}

}  // namespace structnerf
