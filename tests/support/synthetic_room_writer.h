#pragma once

#include "tests/support/synthetic_room.h"

#include <string>

namespace structnerf {

// Writes a room as a folder:
//   images/<name>            photographs, 8-bit PNG
//   sparse/0/*.txt           the model in COLMAP's text format
//   depth/<stem>.png         true z-depth through the pixels' centres, 16-bit,
//                            millimetres of the room (not world units)
//   normal/<stem>.png        true normals through the pixels' centres, camera
//                            frame; 16-bit RGB = x, y, z from -1 to 1
//   fault/<stem>.png         8-bit mask of what the room's fault is about; only
//                            for faults that concern a surface
// The folder appears when all is written. Throws std::runtime_error if it
// exists and is not empty or if a file cannot be written.
void WriteSyntheticRoom(const SyntheticRoom& room, const std::string& folder);

// Throws what WriteSyntheticRoom would throw about the folder.
void CheckRoomFolder(const std::string& folder);

}  // namespace structnerf
