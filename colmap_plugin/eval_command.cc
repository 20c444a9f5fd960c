#include "colmap_plugin/command_line.h"
#include "colmap_plugin/command_runner.h"
#include "colmap_plugin/commands.h"
#include "colmap_plugin/evaluation/evaluation_report.h"
#include "colmap_plugin/evaluation/evaluator.h"
#include "colmap_plugin/input_check.h"
#include "colmap_plugin/text_output.h"
#include "colmap_plugin/truth_arguments.h"

#include <cstdlib>
#include <iostream>

namespace structnerf {
namespace {

struct EvalCommand {
  EvaluationOptions options;
  std::string output_path;
};

bool ParseEvalCommand(const std::vector<std::string>& args,
                      EvalCommand* command) {
  EvaluationOptions& options = command->options;
  colmap::OptionManager manager;
  manager.AddDefaultOption("workspace_path",
                           &options.workspace_path,
                           "Dense workspace, ours or PatchMatch's");
  AddTruthArguments(
      &options.truth, &options.input_path, &options.image_path, &manager);
  manager.AddDefaultOption(
      "min_depth", &options.truth.min_depth, "Nearer truth is ignored, metres");
  manager.AddDefaultOption("max_depth",
                           &options.truth.max_depth,
                           "Farther truth is ignored, metres; 0 = none");
  manager.AddDefaultOption(
      "test_workspace_path",
      &options.held_out.test_workspace_path,
      "Undistorted workspace whose further images neither training nor "
      "structure-from-motion saw");
  manager.AddDefaultOption("lpips_path",
                           &options.held_out.lpips_path,
                           "TorchScript module that computes LPIPS");
  manager.AddDefaultOption("voxel_size",
                           &options.cloud.voxel_size,
                           "Voxels that clouds are reduced to, metres");
  manager.AddDefaultOption("mask_unobserved",
                           &options.cloud.mask_unobserved,
                           "Leave out points where there is no truth");
  manager.AddDefaultOption(
      "output_path", &command->output_path, "JSON file for all results");
  const auto expand = [&](const std::vector<std::string>& project_keys) {
    return ExpandCommandLine(args, project_keys, {"mask_unobserved"});
  };
  std::vector<std::string> expanded =
      expand({"workspace_path", "input_path", "image_path"});
  if (FindOption(expanded, "input_path", "").empty()) {
    // Every project of COLMAP's has images; here they belong to a model.
    expanded = expand({"workspace_path"});
  }
  return ParseArguments(std::move(expanded), &manager);
}

}  // namespace

int RunStructNerfEval(const int argc, char** argv) {
  return RunReportingErrors([&]() {
    EvalCommand command;
    if (!ParseEvalCommand({argv, argv + argc}, &command)) {
      return EXIT_FAILURE;
    }
    command.options.Check();
    if (!command.output_path.empty()) {
      CheckOutputFile("output_path", command.output_path);
    }
    Evaluation evaluation;
    RunWithProgress([&](RunProgress* progress) {
      evaluation = Evaluate(command.options, progress);
      if (!command.output_path.empty()) {
        WriteTextFile(command.output_path, EvaluationJson(evaluation));
      }
    });
    std::cout << EvaluationText(evaluation) << std::flush;
    return EXIT_SUCCESS;
  });
}

}  // namespace structnerf
