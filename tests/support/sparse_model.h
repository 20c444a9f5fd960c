#pragma once

#include "tests/support/synthetic_room.h"

namespace structnerf::room {

// Fills in the room's observations and points from its photographs, as
// structure-from-motion with perfect poses would: noisy observations of image
// corners, points triangulated from them, some wrong matches. The images' poses
// must be in the room's frame, where the points are returned, too.
void AddSparseModel(SyntheticRoom* room);

}  // namespace structnerf::room
