#pragma once

#include "nerf/rendered_view.h"

#include <cstddef>
#include <string>

namespace structnerf {

// The folders of a frame's four images.
constexpr const char* kColorFolder = "color";
constexpr const char* kDepthFolder = "depth";
constexpr const char* kDepthColorFolder = "depth_color";
constexpr const char* kNormalFolder = "normal";

struct FrameOptions {
  // Value of the 16-bit depth images for one unit of the model.
  double depth_scale = 1000;

  // What the ends of the colour scale of depth stand for, model units.
  double nearest_depth = 0;
  double farthest_depth = 1;
};

// Largest depth, model units, that 16 bits hold.
double LargestDepth(const FrameOptions& options);

// Writes a rendered view as four PNGs below `folder`:
//   color/<name>.png         8 bits
//   depth/<name>.png         16 bits, depth times `depth_scale`, 0 = none
//   depth_color/<name>.png   the same for people, near is dark
//   normal/<name>.png        8 bits, camera frame: red right, green up, blue
//                            towards the camera
// Returns the number of pixels whose depth is above LargestDepth; it is written
// as none. Throws std::runtime_error, naming the file, if one cannot be
// written.
size_t WriteFrame(const RenderedView& view,
                  const std::string& name,
                  const FrameOptions& options,
                  const std::string& folder);

}  // namespace structnerf
