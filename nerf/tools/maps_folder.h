#pragma once

#include "nerf/engine/engine_factory.h"
#include "nerf/options.h"
#include "nerf/progress.h"
#include "nerf/reconstructor.h"
#include "nerf/scene.h"

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

namespace structnerf {

// What came out of a run, and how long it took.
struct MapsSummary {
  TrainingSummary training;
  double map_seconds = 0;  // wall time of everything after training
  size_t num_pixels = 0;   // of all views
  size_t num_photometric = 0;
  size_t num_geometric = 0;
};

// Trains on a scene and writes maps of every view into a new folder:
//
//   <path>/stereo/depth_maps/<name>.photometric.bin   every confident pixel
//   <path>/stereo/depth_maps/<name>.geometric.bin     those that other views
//                                                     confirm
//   <path>/stereo/normal_maps/...                     likewise
//
// in the format of nerf/util/array_file.h, with the meaning of
// nerf/dense_maps.h: they are the maps of structnerf_dense with the same scene
// and options. Only masks may differ at their borders, which a scene has at the
// resolution of training. The maps of all views are held in memory, 20 bytes
// per pixel, and 20 more with matching.
//
// `warn` is given sentences about the scene. The folder appears when it is
// complete. Throws std::runtime_error, naming it, if it exists or cannot be
// written; std::invalid_argument if scene or options are wrong; Aborted.
MapsSummary ReconstructIntoFolder(
    Scene scene,
    const ReconstructionOptions& options,
    const EngineFactory& make_engine,
    const std::string& path,
    const std::function<void(const std::string&)>& warn,
    Progress* progress);

}  // namespace structnerf
