#pragma once

#include "tests/support/room_builder.h"

#include <cstdint>

namespace structnerf::room {

// Size of the room in metres: x from west to east, y from south to north.
constexpr double kRoomLength = 5.0;
constexpr double kRoomWidth = 4.0;
constexpr double kRoomHeight = 2.6;

// Pieces of the room, each added as one or more named objects. `seed` varies
// the textures, not the shapes.

// Objects "floor", "ceiling", "wall_north", ..., "skirting", "door", "window".
void AddShell(uint32_t seed, RoomBuilder* builder);

// Objects "rug", "table" and "tableware".
void AddTable(uint32_t seed, RoomBuilder* builder);

// Object "chair", with a closed back and seat or with slats.
void AddChair(uint32_t seed, bool has_slats, RoomBuilder* builder);

// Objects "bookcase" and "books".
void AddBookcase(uint32_t seed, RoomBuilder* builder);

// Objects "sideboard", "sideboard_front" and "sideboard_things".
void AddSideboard(uint32_t seed, bool is_dark_and_glossy, RoomBuilder* builder);

// Objects "poster_north", "poster_east" and "poster_west".
void AddPosters(uint32_t seed, RoomBuilder* builder);

// Objects "armchair" and "crate", or in place of the first "blank_board", which
// has the colour of the wall behind.
void AddArmchair(uint32_t seed, RoomBuilder* builder);
void AddBlankBoard(RoomBuilder* builder);
void AddCrate(uint32_t seed, RoomBuilder* builder);

// Object "lamp", above the table.
void AddLamp(RoomBuilder* builder);

}  // namespace structnerf::room
