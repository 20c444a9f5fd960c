#include "tests/support/room_furniture.h"

namespace structnerf::room {
namespace {

using Eigen::Vector3d;
using Pattern = Material::Pattern;

const Color kWallColor(0.70, 0.68, 0.63);
const Color kWhite(0.80, 0.80, 0.78);

}  // namespace

void AddShell(const uint32_t seed, RoomBuilder* builder) {
  const Vector3d up = Vector3d::UnitZ();
  // The shell's surfaces reach behind each other so that no ray slips through.
  const double length = kRoomLength + 0.02;
  const double width = kRoomWidth + 0.02;
  const double height = kRoomHeight + 0.02;
  const double middle_x = 0.5 * kRoomLength;
  const double middle_y = 0.5 * kRoomWidth;
  const double middle_z = 0.5 * kRoomHeight;

  builder->BeginObject("floor", 0, 0, 0);
  builder->AddBoard(Vector3d(middle_x, middle_y, 0),
                    up,
                    Vector3d::UnitY(),
                    length,
                    width,
                    0,
                    PatternedMaterial(Pattern::kPlanks,
                                      Color(0.44, 0.31, 0.20),
                                      Color(0.30, 0.20, 0.12),
                                      0.16,
                                      seed));
  builder->BeginObject("ceiling", 0, 0, 0);
  builder->AddBoard(Vector3d(middle_x, middle_y, kRoomHeight),
                    -up,
                    Vector3d::UnitY(),
                    length,
                    width,
                    0,
                    PlainMaterial(kWhite));
  builder->BeginObject("wall_north", 0, 0, 0);
  builder->AddBoard(Vector3d(middle_x, kRoomWidth, middle_z),
                    -Vector3d::UnitY(),
                    up,
                    length,
                    height,
                    0,
                    PlainMaterial(kWallColor));
  builder->BeginObject("wall_south", 0, 0, 0);
  builder->AddBoard(Vector3d(middle_x, 0, middle_z),
                    Vector3d::UnitY(),
                    up,
                    length,
                    height,
                    0,
                    PlainMaterial(kWallColor));
  builder->BeginObject("wall_west", 0, 0, 0);
  builder->AddBoard(Vector3d(0, middle_y, middle_z),
                    Vector3d::UnitX(),
                    up,
                    width,
                    height,
                    0,
                    PlainMaterial(kWallColor));
  builder->BeginObject("wall_east", 0, 0, 0);
  builder->AddBoard(Vector3d(kRoomLength, middle_y, middle_z),
                    -Vector3d::UnitX(),
                    up,
                    width,
                    height,
                    0,
                    PlainMaterial(Color(0.46, 0.55, 0.58)));

  builder->BeginObject("skirting", 0, 0, 0);
  const Material skirting = PlainMaterial(kWhite);
  constexpr double kDepth = 0.015;
  constexpr double kHeight = 0.07;
  builder->AddBox(
      Vector3d(0, 0, 0), Vector3d(kRoomLength, kDepth, kHeight), skirting);
  builder->AddBox(Vector3d(0, kRoomWidth - kDepth, 0),
                  Vector3d(kRoomLength, kRoomWidth, kHeight),
                  skirting);
  builder->AddBox(
      Vector3d(0, 0, 0), Vector3d(kDepth, kRoomWidth, kHeight), skirting);
  builder->AddBox(Vector3d(kRoomLength - kDepth, 0, 0),
                  Vector3d(kRoomLength, kRoomWidth, kHeight),
                  skirting);

  builder->BeginObject("door", 0, 0.75, 0);
  builder->AddBox(Vector3d(0, -0.46, 0),
                  Vector3d(0.03, 0.46, 2.05),
                  PlainMaterial(Color(0.62, 0.60, 0.55)));
  builder->AddBox(Vector3d(0, -0.42, 0),
                  Vector3d(0.04, 0.42, 2.01),
                  PlainMaterial(Color(0.50, 0.42, 0.32)));
  builder->AddSphere(
      Vector3d(0.07, 0.34, 1.02), 0.03, PlainMaterial(Color(0.15, 0.13, 0.10)));

  builder->BeginObject("window", kRoomLength, 1.0, 0);
  builder->AddBox(Vector3d(-0.03, -0.75, 0.85),
                  Vector3d(0, 0.75, 2.25),
                  PlainMaterial(kWhite));
  Material pane = PlainMaterial(Color(0.85, 0.92, 1.0));
  pane.emission = 1.6;
  builder->AddBox(Vector3d(-0.035, -0.70, 0.90), Vector3d(0, 0.70, 2.20), pane);
}

void AddPosters(const uint32_t seed, RoomBuilder* builder) {
  const Vector3d up = Vector3d::UnitZ();
  builder->BeginObject("poster_north", 2.55, kRoomWidth, 0);
  builder->AddBoard(Vector3d(0, -0.015, 1.62),
                    -Vector3d::UnitY(),
                    up,
                    0.62,
                    0.86,
                    0.015,
                    PatternedMaterial(Pattern::kPicture,
                                      Color(0.70, 0.52, 0.22),
                                      Color(0.14, 0.28, 0.40),
                                      0.19,
                                      seed));
  builder->BeginObject("poster_east", kRoomLength, 2.75, 0);
  builder->AddBoard(Vector3d(-0.015, 0, 1.55),
                    -Vector3d::UnitX(),
                    up,
                    0.8,
                    0.55,
                    0.015,
                    PatternedMaterial(Pattern::kPicture,
                                      Color(0.20, 0.35, 0.18),
                                      Color(0.66, 0.62, 0.50),
                                      0.16,
                                      seed + 50));
  builder->BeginObject("poster_west", 0, 3.05, 0);
  builder->AddBoard(Vector3d(0.015, 0, 1.5),
                    Vector3d::UnitX(),
                    up,
                    0.5,
                    0.5,
                    0.015,
                    PatternedMaterial(Pattern::kPicture,
                                      Color(0.62, 0.20, 0.12),
                                      Color(0.70, 0.66, 0.55),
                                      0.13,
                                      seed + 90));
}

void AddBlankBoard(RoomBuilder* builder) {
  builder->BeginObject("blank_board", 4.05, 3.6, 0);
  // It gets more light than the wall behind and reflects as much less, so that
  // both look the same.
  builder->AddBox(Vector3d(-0.38, -0.01, 0),
                  Vector3d(0.38, 0.01, 1.35),
                  PlainMaterial(0.80 * kWallColor));
}

void AddLamp(RoomBuilder* builder) {
  builder->BeginObject("lamp", 2.7, 2.15, 0);
  builder->AddCylinder(
      Vector3d(0, 0, 2.1), 0.006, 0.5, PlainMaterial(Color(0.05, 0.05, 0.05)));
  Material shade = PlainMaterial(Color(0.80, 0.74, 0.62));
  shade.emission = 0.35;
  builder->AddCylinder(Vector3d(0, 0, 1.95), 0.2, 0.15, shade);
}

}  // namespace structnerf::room
