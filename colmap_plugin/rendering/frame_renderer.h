#pragma once

#include "colmap_plugin/run_progress.h"

#include <cstddef>
#include <string>

namespace structnerf {

struct RenderOptions {
  // Dense workspace that structnerf_dense has left, with its field.
  std::string workspace_path;

  // Folder for the frames.
  std::string output_path;

  // "input": from photograph to photograph in the order of their names.
  // "orbit": around the centre of the middle photograph, looking at what it
  // looks at.
  std::string path = "input";

  // Instead of a path, if not empty: a COLMAP model with undistorted cameras,
  // or a text file (novel_path.h) whose poses take the first photograph's
  // camera.
  std::string poses_path;

  // Of a path.
  int num_frames = 60;

  // Radius of the orbit, relative to the depth of what it looks at.
  double orbit_radius = 0.15;

  // Value of the 16-bit depth images for one unit of the model.
  double depth_scale = 1000;

  // Longest side of the frames in pixels; -1 = as the camera.
  int max_image_size = -1;

  // Whether frames that are there may be replaced by those of the same names.
  bool overwrite = false;

  // Throws std::runtime_error, naming the option, if one is wrong.
  void Check() const;
};

// Renders what a trained field looks like from places where nobody took a
// photograph, and writes it as WriteFrame does. Either all frames are written
// or none. Returns how many. Throws std::runtime_error with one sentence about
// what is wrong, Aborted if told to.
size_t RenderFrames(const RenderOptions& options, RunProgress* progress);

}  // namespace structnerf
