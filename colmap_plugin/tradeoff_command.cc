#include "colmap_plugin/command_line.h"
#include "colmap_plugin/command_runner.h"
#include "colmap_plugin/commands.h"
#include "colmap_plugin/text_output.h"
#include "colmap_plugin/tradeoff/tradeoff_report.h"
#include "nerf/util/interrupts.h"

#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <stdexcept>
#include <utility>

namespace structnerf {
namespace {

namespace fs = std::filesystem;

constexpr int kMaxSeeds = 100;

struct TradeoffCommand {
  TradeoffScene scene;
  std::string settings = "quality=low, quality=medium, quality=high";
  int num_seeds = 1;
};

bool ParseTradeoffCommand(const std::vector<std::string>& args,
                          TradeoffCommand* command) {
  TradeoffScene& scene = command->scene;
  colmap::OptionManager manager;
  manager.AddDefaultOption(
      "image_path", &scene.image_path, "Folder with the original images");
  manager.AddDefaultOption("input_path",
                           &scene.input_path,
                           "Folder with the sparse model, e.g. sparse/0");
  manager.AddDefaultOption(
      "output_path", &scene.output_path, "Folder for all that is written");
  manager.AddDefaultOption(
      "mask_path",
      &scene.mask_path,
      "Folder with masks <image name>.png, black = ignore");
  manager.AddDefaultOption("settings",
                           &command->settings,
                           "Settings to try: a comma between settings, blanks "
                           "between the options of one, e.g. \"quality=low, "
                           "quality=high num_steps=3000, max_minutes=2\"");
  manager.AddDefaultOption(
      "num_seeds", &command->num_seeds, "Runs of each setting");
  manager.AddDefaultOption(
      "ground_truth_path",
      &scene.truth.path,
      "Folder with 16-bit depth PNGs named after the images; empty = measured "
      "by photographs that are kept out");
  manager.AddDefaultOption(
      "depth_scale", &scene.truth.scale, "Their value for one metre");
  return ParseArguments(
      ExpandCommandLine(args, {"image_path", "input_path", "mask_path"}, {}),
      &manager);
}

void CheckCommand(const TradeoffCommand& command) {
  RequireOptions({{"image_path", command.scene.image_path},
                  {"input_path", command.scene.input_path},
                  {"output_path", command.scene.output_path}},
                 "--image_path, --input_path and --output_path");
  if (command.num_seeds < 1 || command.num_seeds > kMaxSeeds) {
    throw std::runtime_error("The option --num_seeds must be between 1 and " +
                             std::to_string(kMaxSeeds) + ", but is " +
                             std::to_string(command.num_seeds) + ".");
  }
  if (!command.scene.truth.path.empty()) {
    command.scene.truth.Check();
  }
}

void SayWhatWasMeasured(const TradeoffSetting& setting,
                        const int seed,
                        const TradeoffMeasurement& measurement) {
  std::cout << setting.name << ", seed " << seed << ": "
            << DurationText(measurement.seconds) << ", "
            << FormatNumber("%.1f", measurement.cpu_seconds) << " CPU s, "
            << FormatNumber("%.1f", 100 * measurement.error)
            << " % of the pixels wrong" << std::endl;
}

}  // namespace

int RunStructNerfTradeoff(const int argc, char** argv) {
  return RunReportingErrors([&]() {
    TradeoffCommand command;
    if (!ParseTradeoffCommand({argv, argv + argc}, &command)) {
      return EXIT_FAILURE;
    }
    CheckCommand(command);
    std::vector<MeasuredSetting> settings;
    for (TradeoffSetting& setting : ParseTradeoffSettings(command.settings)) {
      if (!AreDenseOptions(setting.arguments)) {
        return EXIT_FAILURE;
      }
      settings.push_back({std::move(setting), {}});
    }
    PrepareScene(&command.scene);
    fs::create_directories(command.scene.output_path);
    const ScopedInterrupts interrupts;  // the run ends itself then
    // Seed by seed, so that what was measured so far says something about all.
    for (int seed = 0; seed < command.num_seeds; ++seed) {
      for (MeasuredSetting& setting : settings) {
        setting.measurements.push_back(
            MeasureSetting(command.scene, setting.setting, seed));
        SayWhatWasMeasured(setting.setting, seed, setting.measurements.back());
        if (ScopedInterrupts::Count() > 0) {
          throw std::runtime_error(
              "Quit before the end; the same command goes on from here.");
        }
      }
    }
    std::cout << WriteTradeoffReport(command.scene, settings) << std::endl
              << "See " << command.scene.output_path << "/tradeoff.html."
              << std::endl;
    return EXIT_SUCCESS;
  });
}

}  // namespace structnerf
