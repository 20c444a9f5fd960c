#pragma once

#include <string>
#include <vector>

namespace structnerf {

// One way to run the dense stage.
struct TradeoffSetting {
  std::string name;                    // as it was given, e.g. "quality=low"
  std::vector<std::string> arguments;  // e.g. {"--StructNeRF.quality=low"}

  // The name as that of a folder.
  std::string FolderName() const;
};

// Settings from a text as "quality=low, quality=high num_steps=6000": a comma
// between settings, blanks between the options of one. Names without a section
// are of StructNeRF. Throws std::runtime_error, naming the part that is wrong,
// also if there is none or two are the same.
std::vector<TradeoffSetting> ParseTradeoffSettings(const std::string& text);

}  // namespace structnerf
