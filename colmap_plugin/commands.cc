#include "colmap_plugin/commands.h"

#include "colmap_plugin/cloud_fusion.h"
#include "colmap_plugin/colmap_compat.h"
#include "colmap_plugin/command_line.h"
#include "colmap_plugin/command_runner.h"
#include "colmap_plugin/image_decisions.h"
#include "colmap_plugin/input_check.h"
#include "colmap_plugin/log_level.h"
#include "colmap_plugin/option_table.h"
#include "colmap_plugin/quality_choice.h"
#include "colmap_plugin/run_plan.h"
#include "colmap_plugin/scene_converter.h"
#include "colmap_plugin/stock_colmap.h"
#include "colmap_plugin/structnerf_controller.h"
#include "colmap_plugin/terminal_progress.h"
#include "nerf/analysis/scene_analysis.h"
#include "nerf/util/interrupts.h"

#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <memory>
#include <stdexcept>

#include <colmap/controllers/option_manager.h>

#include <unistd.h>

namespace structnerf {
namespace {

namespace fs = std::filesystem;

const std::vector<std::string> kFlags = {"overwrite",
                                         "StructNeRF.print_options"};

// Keys and sections of a project file.
const std::vector<std::string> kProjectKeys = {"StructNeRF.",
                                               "StereoFusion.",
                                               "image_path",
                                               "input_path",
                                               "output_path",
                                               "workspace_path",
                                               "mask_path",
                                               "overwrite"};

struct DenseCommand {
  StructNerfOptions options;
  std::string input_path;

  // That of `input_path`, if it has been read already.
  std::shared_ptr<const colmap::Reconstruction> model;

  bool print_options = false;
};

// Throws std::runtime_error if the paths contradict each other.
void CheckPaths(const DenseCommand& command) {
  const StructNerfOptions& options = command.options;
  if (!options.workspace_path.empty()) {
    if (!options.output_path.empty() || !command.input_path.empty()) {
      throw std::runtime_error(
          "--workspace_path runs on an existing workspace; leave out "
          "--input_path and --output_path, or --workspace_path.");
    }
    CheckWorkspaceFolder(options.workspace_path);
    return;
  }
  RequireOptions({{"image_path", options.image_path},
                  {"input_path", command.input_path},
                  {"output_path", options.output_path}},
                 "--image_path, --input_path and --output_path, or "
                 "--workspace_path");
  const std::string sparse_path =
      DenseWorkspace(options.output_path).SparsePath();
  if (fs::exists(sparse_path) && fs::exists(command.input_path) &&
      fs::equivalent(sparse_path, command.input_path)) {
    throw std::runtime_error("The output folder " + options.output_path +
                             " would overwrite the model in " +
                             command.input_path + "; choose another one.");
  }
}

// With the options of `quality` as defaults. Returns false if the command line
// is wrong, which has been said then.
bool ParseOptionsOfQuality(const std::vector<std::string>& args,
                           const std::string& quality,
                           DenseCommand* command) {
  StructNerfOptions& options = command->options;
  options.quality = quality;
  const std::string method =
      FindOption(args, "StructNeRF.method", options.method);
  options.method = method;
  options.reconstruction = MakePreset(options.method, options.quality);
  const std::vector<OptionEntry> table = MakeOptionTable(&options);

  colmap::OptionManager manager;
  manager.AddDefaultOption(
      "image_path", &options.image_path, "Folder with the original images");
  manager.AddDefaultOption("input_path",
                           &command->input_path,
                           "Folder with the sparse model, e.g. sparse/0");
  manager.AddDefaultOption(
      "output_path", &options.output_path, "Folder of the new dense workspace");
  manager.AddDefaultOption(
      "workspace_path",
      &options.workspace_path,
      "Existing workspace of image_undistorter, instead of the three above");
  manager.AddDefaultOption(
      "mask_path",
      &options.mask_path,
      "Folder with masks <image name>.png, black = ignore; with "
      "--workspace_path of the undistorted images");
  manager.AddDefaultOption(
      "overwrite", &options.overwrite, "Replace existing dense results");
  AddOptions(table, &manager);
  manager.AddDefaultOption("StructNeRF.print_options",
                           &command->print_options,
                           "Only print what the options come to, on the scene "
                           "of --input_path if that is given");
  manager.stereo_fusion->min_num_pixels = options.fusion.min_num_pixels;
  manager.AddStereoFusionOptions();

  if (!ParseArguments(args, &manager)) {
    return false;
  }
  CheckPresetWords(options, method, quality);
  options.fusion = *manager.stereo_fusion;
  // COLMAP's own option.
  const std::string seed = FindOption(args, "random_seed", "");
  if (!seed.empty() && FindOption(args, "StructNeRF.seed", "").empty()) {
    options.reconstruction.training.seed = std::stoi(seed);
  }
  CheckOptions(options);
  return true;
}

std::string ModelPath(const DenseCommand& command) {
  const std::string& workspace_path = command.options.workspace_path;
  return workspace_path.empty() ? command.input_path
                                : DenseWorkspace(workspace_path).SparsePath();
}

// Returns false if the command line is wrong, which has been said then.
bool ParseDenseCommand(const std::vector<std::string>& raw_args,
                       DenseCommand* command) {
  const std::vector<std::string> args =
      ExpandCommandLine(raw_args, kProjectKeys, kFlags);
  const std::string quality = FindOption(args, "StructNeRF.quality", "");
  if (!ParseOptionsOfQuality(
          args,
          quality.empty() ? StructNerfOptions().quality : quality,
          command)) {
    return false;
  }
  const bool quality_by_time =
      quality.empty() && command->options.max_minutes > 0;
  if (!command->options.workspace_path.empty() &&
      !FindOption(raw_args, "image_path", "").empty()) {
    throw std::runtime_error(
        "--workspace_path runs on an existing workspace and its images; leave "
        "out --image_path.");
  }
  if (!command->print_options) {
    CheckPaths(*command);
  }
  if (quality_by_time) {
    if (ModelPath(*command).empty()) {
      throw std::runtime_error(
          "Which quality fits into --StructNeRF.max_minutes depends on the "
          "number and size of the images; give their model as --input_path, or "
          "--StructNeRF.quality.");
    }
    const auto model = std::make_shared<const colmap::Reconstruction>(
        ReadModel(ModelPath(*command)));
    CheckModel(*model);
    const QualityChoice choice =
        ChooseQuality(command->options, UndistortedCameras(*model));
    *command = DenseCommand();
    ParseOptionsOfQuality(args, choice.quality, command);
    if (FindOption(args, "StructNeRF.stereo_num_iterations", "").empty()) {
      command->options.reconstruction.stereo.num_iterations = choice.num_sweeps;
    }
    command->model = model;
  }
  // From the project file, if not from the command line.
  if (FindOption(raw_args, "StereoFusion.min_num_pixels", "").empty()) {
    ForgetDefaultMinNumPixels(&command->options.fusion);
  }
  return true;
}

// That of the command, which may have been read already.
std::shared_ptr<const colmap::Reconstruction> ModelOf(
    const DenseCommand& command) {
  return command.model != nullptr
             ? command.model
             : std::make_shared<const colmap::Reconstruction>(
                   ReadModel(ModelPath(command)));
}

// With what the scene decides, if one is given.
void PrintOptions(const DenseCommand& command) {
  StructNerfOptions options = command.options;
  std::vector<SceneDecision> decisions;
  if (!ModelPath(command).empty()) {
    const auto model = ModelOf(command);
    CheckModel(*model);
    decisions = DescribeImages(
        options, *model, options.reconstruction.training.max_image_size);
    SceneAnalysis analysis =
        AnalyzeScene(OutlineScene(*model), options.reconstruction);
    options.reconstruction = std::move(analysis.options);
    decisions.insert(
        decisions.end(), analysis.decisions.begin(), analysis.decisions.end());
  }
  for (const OptionEntry& entry : MakeOptionTable(&options)) {
    std::cout << OptionText(entry) << std::endl;
  }
  for (const SceneDecision& decision : decisions) {
    std::cout << "# " << decision.Text() << std::endl;
  }
}

// Runs the controller on a terminal; throws what it failed with.
int RunController(const DenseCommand& command) {
  std::shared_ptr<const colmap::Reconstruction> reconstruction;
  if (command.options.workspace_path.empty()) {
    reconstruction = ModelOf(command);
  }
  const ScopedInterrupts interrupts;
  // COLMAP's own lines would tear the progress line apart.
  const ScopedLogLevel quiet(google::GLOG_ERROR);
  auto progress = std::make_unique<TerminalProgress>(
      &std::cerr, TerminalProgress::OptionsFor(STDERR_FILENO));
  StructNerfController controller(
      command.options, reconstruction, progress.get());
  controller.Run();
  if (controller.GetStatus() == StructNerfController::Status::kSuccess) {
    progress->Finish();
    std::cout << ReportText(controller.Report()) << std::flush;
    return EXIT_SUCCESS;
  }
  progress.reset();  // ends the progress line before the message
  std::string error = controller.Error();
  if (controller.GetStatus() == StructNerfController::Status::kAborted) {
    error = controller.KeptPath().empty()
                ? "Quit before the end; nothing was written."
                : "Quit before the end.";
  }
  if (!controller.KeptPath().empty()) {
    error += " The same command goes on from what was done, which is in " +
             controller.KeptPath() + ".";
  }
  throw std::runtime_error(error);
}

}  // namespace

const std::vector<Command>& Commands() {
  static const std::vector<Command> commands = {
      {"structnerf_dense",
       "Dense depth, normals and cloud from a sparse model, without CUDA",
       RunStructNerfDense},
      {"structnerf_eval",
       "Errors of a dense workspace against ground truth and held-out images",
       RunStructNerfEval},
      {"structnerf_compare",
       "Two dense workspaces side by side: numbers and an HTML page",
       RunStructNerfCompare},
      {"structnerf_render",
       "Images, depth and normals of new views",
       RunStructNerfRender},
      {"structnerf_tradeoff",
       "Time against error of several settings on your scene",
       RunStructNerfTradeoff}};
  return commands;
}

bool AreDenseOptions(const std::vector<std::string>& options) {
  std::vector<std::string> args = {"structnerf_dense"};
  args.insert(args.end(), options.begin(), options.end());
  args = ExpandCommandLine(args, {}, kFlags);
  DenseCommand command;
  return ParseOptionsOfQuality(
      args,
      FindOption(args, "StructNeRF.quality", StructNerfOptions().quality),
      &command);
}

int RunStructNerfDense(const int argc, char** argv) {
  return RunReportingErrors([&]() {
    DenseCommand command;
    if (!ParseDenseCommand({argv, argv + argc}, &command)) {
      return EXIT_FAILURE;
    }
    if (command.print_options) {
      PrintOptions(command);
      return EXIT_SUCCESS;
    }
    return RunController(command);
  });
}

int RunHelp(const std::vector<Command>& commands) {
  try {
    RunStockColmap({"help"});
  } catch (const std::exception& error) {
    std::cout << error.what() << std::endl << std::endl;
  }
  std::cout << "Commands of colmap-structnerf:" << std::endl;
  for (const Command& command : commands) {
    std::cout << "  " << command.name << "  " << command.help << std::endl;
  }
  std::cout << std::endl;
  return EXIT_SUCCESS;
}

int RunVersion() {
  std::cout << "colmap-structnerf " << STRUCTNERF_VERSION << ", built with "
            << ColmapVersionInfo() << std::endl;
  return EXIT_SUCCESS;
}

}  // namespace structnerf
