#pragma once

#include "colmap_plugin/dense_workspace.h"
#include "colmap_plugin/stage_progress.h"
#include "nerf/options.h"
#include "nerf/scene.h"

#include <cstddef>
#include <string>
#include <vector>

namespace structnerf {

struct MapAveragingOptions {
  // Of all views.
  std::vector<std::string> image_names;

  // For maps that are held at once.
  size_t max_bytes = 0;

  ExtractionOptions extraction;
  int num_threads = -1;  // -1 = all cores
};

// Averages the depth of all maps of a workspace over views that see the same
// surface (nerf/extract/depth_averaging.h). Photometric maps change first: each
// by what the geometric ones of other views say, as they were. Then geometric
// ones become those pixels of the photometric ones whose mean is of enough
// views. Consistency graphs and confidence are written with them.
//
// To be done after the cloud was fused: fusion averages over views itself, and
// tells wrong depth by its disagreement, which is gone afterwards.
//
// `scene`: cameras and poses will do. `averaging_views`:
// Reconstructor::AveragingViews. Returns the number of geometric depths of each
// view. Throws Aborted if told to, std::runtime_error if a file cannot be read
// or written.
std::vector<size_t> AverageMaps(
    const MapAveragingOptions& options,
    const Scene& scene,
    const std::vector<std::vector<int>>& averaging_views,
    const DenseWorkspace& workspace,
    StageProgress* stage);

}  // namespace structnerf
