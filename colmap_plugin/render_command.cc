#include "colmap_plugin/command_line.h"
#include "colmap_plugin/command_runner.h"
#include "colmap_plugin/commands.h"
#include "colmap_plugin/rendering/frame_renderer.h"

#include <cstdlib>
#include <iostream>

namespace structnerf {
namespace {

bool ParseRenderCommand(const std::vector<std::string>& args,
                        RenderOptions* options) {
  colmap::OptionManager manager;
  manager.AddDefaultOption("workspace_path",
                           &options->workspace_path,
                           "Dense workspace of structnerf_dense");
  manager.AddDefaultOption(
      "output_path", &options->output_path, "Folder for the frames");
  manager.AddDefaultOption("path",
                           &options->path,
                           "{input, orbit}: along the photographs in the "
                           "order of their names, or around the middle one");
  manager.AddDefaultOption(
      "poses_path",
      &options->poses_path,
      "Instead of a path: an undistorted COLMAP model, or a text file with "
      "lines NAME QW QX QY QZ TX TY TZ (camera from world)");
  manager.AddDefaultOption(
      "num_frames", &options->num_frames, "Frames of a path");
  manager.AddDefaultOption("orbit_radius",
                           &options->orbit_radius,
                           "Radius of the orbit, relative to the depth of "
                           "what it looks at");
  manager.AddDefaultOption("depth_scale",
                           &options->depth_scale,
                           "Value of the depth PNGs for one model unit");
  manager.AddDefaultOption("max_image_size",
                           &options->max_image_size,
                           "Longest side in pixels; -1 = the camera's");
  manager.AddDefaultOption("overwrite",
                           &options->overwrite,
                           "Replace frames of the same names; others stay");
  return ParseArguments(
      ExpandCommandLine(args, {"workspace_path", "output_path"}, {"overwrite"}),
      &manager);
}

}  // namespace

int RunStructNerfRender(const int argc, char** argv) {
  return RunReportingErrors([&]() {
    RenderOptions options;
    if (!ParseRenderCommand({argv, argv + argc}, &options)) {
      return EXIT_FAILURE;
    }
    options.Check();
    size_t num_frames = 0;
    RunWithProgress([&](RunProgress* progress) {
      num_frames = RenderFrames(options, progress);
    });
    std::cout << num_frames << " frames in " << options.output_path
              << ": color, depth, depth_color, normal" << std::endl;
    return EXIT_SUCCESS;
  });
}

}  // namespace structnerf
