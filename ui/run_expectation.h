#pragma once

#include "colmap_plugin/structnerf_options.h"

#include <string>

#include <colmap/scene/reconstruction.h>

namespace structnerf {

// What a run on a model will be like, in sentences, before it has begun.
struct RunExpectation {
  std::string text;
  bool is_possible = false;  // else the text says why not
};

RunExpectation ExpectRun(const StructNerfOptions& options,
                         const colmap::Reconstruction& reconstruction);

}  // namespace structnerf
