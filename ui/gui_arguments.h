#pragma once

#include "colmap_plugin/structnerf_options.h"

#include <string>

#include <colmap/controllers/option_manager.h>

namespace structnerf {

// What a window starts from. Not to be copied once it was parsed: the manager
// knows where the options are.
struct GuiArguments {
  StructNerfOptions options;
  colmap::OptionManager manager;
  std::string import_path;  // of a model to show; empty = none
};

// Those of `colmap gui` and --StructNeRF.*. Returns false if the command line
// is wrong, which has been said then, or throws std::exception.
bool ParseGuiArguments(int argc, char** argv, GuiArguments* arguments);

}  // namespace structnerf
