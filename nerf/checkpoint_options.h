#pragma once

#include <map>
#include <stdexcept>
#include <string>

namespace structnerf {

// Where training is saved on the way, so that a run that was killed can go on.
struct CheckpointOptions {
  // Holds the newest checkpoint and the one before it; must exist. Empty = no
  // checkpoints.
  std::string folder;

  // From one to the next. Others are written when training ends, or is told to
  // end and to save. Not positive = none is written, but one that is there is
  // used.
  double interval_seconds = 300;

  // What the run is told from others by: names and values of options and the
  // like. Only a checkpoint of the same run is used.
  std::map<std::string, std::string> run;
};

// A checkpoint that was found.
struct CheckpointInfo {
  int num_steps = -1;        // done; -1 = there is none
  bool is_complete = false;  // training has ended

  // A sentence about damaged checkpoints that were passed over, empty if none.
  std::string warning;
};

// A checkpoint of another run or program. Says what is different.
class CheckpointMismatch : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Whether there is a checkpoint, damaged or not, of whatever run.
bool HasCheckpoint(const std::string& folder);

// Looks for a checkpoint without a scene at hand: `options.run` is compared.
// Throws CheckpointMismatch.
CheckpointInfo FindCheckpoint(const CheckpointOptions& options);

}  // namespace structnerf
