#pragma once

#include "nerf/reconstructor.h"
#include "tests/support/synthetic_room.h"

#include <string>
#include <vector>

#include <Eigen/Core>

namespace structnerf {

// The small generated room that all cases are changes of. Images so small show
// few corners, so its sparse points are made from the truth: a regular sample
// of what two views or more see, with errors of reprojection up to 1.5 pixels.
const SyntheticRoom& StabilityRoom();
const Scene& StabilityScene();

// Few steps and rays, one of everything.
ReconstructionOptions StabilityOptions();

struct RoomRun {
  std::vector<DenseMaps> maps;  // of all views
  TrainingSummary summary;
  std::vector<std::string> warnings;
};

// Trains on the scene and renders all its views. Throws UnstableError unless
// maps hold what DenseMaps promises and everything is finite.
RoomRun RunScene(const Scene& scene, const ReconstructionOptions& options);

// The room as it is, computed once, and once more from another seed.
const RoomRun& BaseRun();
const RoomRun& OtherSeedRun();

// Relative error of depths against the truth of the room, in percent: the
// median over all pixels of all views, a missing depth counting as 100.
// `world_scale`: of the maps.
double MedianError(const std::vector<DenseMaps>& maps, double world_scale = 1);

// RunScene on a changed room, whose error must not exceed `max_error` percent.
// Returns a sentence with its error and the base's, and the guards that acted.
std::string MeasureScene(const Scene& scene,
                         const ReconstructionOptions& options,
                         double max_error);

// "guards: restored_snapshot 2", or nothing if none acted.
std::string GuardText(const TrainingSummary& summary);

}  // namespace structnerf
