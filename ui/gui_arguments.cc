#include "ui/gui_arguments.h"

#include "colmap_plugin/colmap_compat.h"
#include "colmap_plugin/command_line.h"
#include "colmap_plugin/command_runner.h"
#include "colmap_plugin/option_table.h"

#include <string>
#include <vector>

namespace structnerf {
namespace {

constexpr char kSection[] = "StructNeRF.";

}  // namespace

bool ParseGuiArguments(const int argc, char** argv, GuiArguments* arguments) {
  StructNerfOptions& options = arguments->options;
  colmap::OptionManager& manager = arguments->manager;
  const std::vector<std::string> args =
      ExpandCommandLine({argv, argv + argc}, {kSection}, {});
  options.quality = FindOption(args, "StructNeRF.quality", options.quality);
  options.method = FindOption(args, "StructNeRF.method", options.method);
  options.reconstruction = MakePreset(options.method, options.quality);
  // From COLMAP 4.0 on, what is added here is also kept in project files.
  AddOptions(MakeOptionTable(&options), &manager);
  if (argc > 1) {
    manager.AddDefaultOption("import_path", &arguments->import_path);
    manager.AddAllOptions();
    const StructNerfOptions given = options;
    if (!ParseOptions(argc, argv, &manager)) {
      return false;
    }
    // With a project file, COLMAP has left out the command line.
    colmap::OptionManager own(/*add_project_options=*/false);
    AddOptions(MakeOptionTable(&options), &own);
    if (!ParseArguments(KeepSection(args, kSection), &own)) {
      return false;
    }
    CheckPresetWords(options, given.method, given.quality);
  }
  return true;
}

}  // namespace structnerf
