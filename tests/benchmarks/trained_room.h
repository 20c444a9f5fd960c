#pragma once

#include "nerf/engine/grid_engine.h"
#include "nerf/options.h"

#include <memory>
#include <string>
#include <vector>

namespace structnerf {

// Engine options of a quality word, as sphere_room.h completes them.
EngineOptions PresetEngineOptions(const std::string& quality, int num_threads);

// An engine, and the room of sphere_room.h that it is trained on.
class TrainedRoom {
 public:
  // `num_rays` per step, a multiple of kMaxTileRays.
  TrainedRoom(std::unique_ptr<GridEngine> engine, int num_rays);

  // Takes training steps as the trainer does. Returns the last one's loss.
  double Train(int num_steps);

  GridEngine& Engine() { return *engine_; }

  int NumSteps() const { return step_.step; }

  // Rays of the next step.
  std::vector<RayTile> NextRays();

  // Accumulates the gradient of the next step and counts the entries of the
  // grid that have one.
  size_t CountTouchedEntries();

 private:
  std::unique_ptr<GridEngine> engine_;
  std::vector<std::unique_ptr<TileObjective>> objectives_;
  StepParameters step_;
};

}  // namespace structnerf
