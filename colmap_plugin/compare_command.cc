#include "colmap_plugin/command_line.h"
#include "colmap_plugin/command_runner.h"
#include "colmap_plugin/commands.h"
#include "colmap_plugin/evaluation/comparison.h"
#include "colmap_plugin/evaluation/comparison_report.h"
#include "colmap_plugin/truth_arguments.h"

#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <stdexcept>

namespace structnerf {
namespace {

namespace fs = std::filesystem;

struct CompareCommand {
  ComparisonOptions options;
  std::string output_path;
};

// The two workspaces may come first, without the names of their options.
std::vector<std::string> NameWorkspaces(std::vector<std::string> args) {
  const char* const names[] = {"--workspace_path_a", "--workspace_path_b"};
  for (size_t i = 0; i < 2; ++i) {
    const size_t place = 1 + 2 * i;
    if (args.size() <= place || args[place].compare(0, 1, "-") == 0) {
      break;
    }
    args.insert(args.begin() + static_cast<ptrdiff_t>(place), names[i]);
  }
  return args;
}

bool ParseCompareCommand(const std::vector<std::string>& args,
                         CompareCommand* command) {
  ComparisonOptions& options = command->options;
  colmap::OptionManager manager;
  manager.AddDefaultOption("workspace_path_a",
                           &options.workspace_paths[0],
                           "Dense workspace A, ours or PatchMatch's; may be "
                           "given first, without this name");
  manager.AddDefaultOption("workspace_path_b",
                           &options.workspace_paths[1],
                           "Dense workspace B; may be given second");
  manager.AddDefaultOption("output_path",
                           &command->output_path,
                           "Folder for comparison.html and comparison.json");
  AddTruthArguments(
      &options.truth, &options.input_path, &options.image_path, &manager);
  manager.AddDefaultOption("input_type",
                           &options.map_type,
                           "Maps to compare {geometric, photometric}");
  manager.AddDefaultOption("max_pictured_views",
                           &options.max_pictured_views,
                           "Views that pictures are shown of; 0 = all");
  manager.AddDefaultOption("picture_size",
                           &options.picture_size,
                           "Longest side of the pictures in pixels");
  return ParseArguments(ExpandCommandLine(NameWorkspaces(args), {}, {}),
                        &manager);
}

}  // namespace

int RunStructNerfCompare(const int argc, char** argv) {
  return RunReportingErrors([&]() {
    CompareCommand command;
    if (!ParseCompareCommand({argv, argv + argc}, &command)) {
      return EXIT_FAILURE;
    }
    command.options.Check();
    RequireOptions({{"output_path", command.output_path}},
                   "the folder for the page");
    if (fs::exists(command.output_path) &&
        !fs::is_directory(command.output_path)) {
      throw std::runtime_error("The option --output_path is " +
                               command.output_path +
                               ", but that is no folder; give another name.");
    }
    Comparison comparison;
    std::string page_path;
    RunWithProgress([&](RunProgress* progress) {
      comparison = Compare(command.options, progress);
      page_path = WriteComparison(comparison, command.output_path);
    });
    std::cout << ComparisonText(comparison) << "Page: " << page_path
              << std::endl;
    return EXIT_SUCCESS;
  });
}

}  // namespace structnerf
