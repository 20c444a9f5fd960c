#include "tests/support/room_furniture.h"

#include "tests/support/value_noise.h"

#include <cmath>

namespace structnerf::room {
namespace {

using Eigen::Vector3d;
using Pattern = Material::Pattern;

void AddShelfOfBooks(const double width,
                     const double depth,
                     const double z,
                     const uint32_t seed,
                     RoomBuilder* builder) {
  const auto uniform = [&](const int book, const int what) {
    return HashedUniform(book, what, 0, seed);
  };
  double x = 0.01;
  for (int book = 0; x < width - 0.05; ++book) {
    const double thickness = 0.022 + 0.038 * uniform(book, 0);
    const double height = 0.17 + 0.11 * uniform(book, 1);
    const double front = 0.03 + 0.05 * uniform(book, 2);
    if (uniform(book, 3) < 0.12) {  // a gap
      x += 0.08;
      continue;
    }
    const Color cover(0.04 + 0.55 * uniform(book, 4),
                      0.04 + 0.40 * uniform(book, 5),
                      0.04 + 0.40 * uniform(book, 6));
    const Color print =
        cover.sum() > 0.6 ? Color(0.05, 0.04, 0.04) : Color(0.75, 0.68, 0.45);
    builder->AddBox(Vector3d(x, front, z),
                    Vector3d(x + thickness, depth, z + height),
                    PatternedMaterial(Pattern::kStripes,
                                      cover,
                                      print,
                                      0.028 + 0.03 * uniform(book, 7),
                                      seed + 100 * book));
    x += thickness + 0.002;
  }
}

void AddPlant(const Vector3d& base, const uint32_t seed, RoomBuilder* builder) {
  builder->AddCylinder(base,
                       0.08,
                       0.14,
                       PatternedMaterial(Pattern::kSpeckle,
                                         Color(0.45, 0.18, 0.09),
                                         Color(0.30, 0.11, 0.05),
                                         0.04,
                                         seed));
  for (int i = 0; i < 9; ++i) {
    const double angle = 2.4 * i;
    const double reach = 0.035 * std::sqrt(i + 0.3);
    builder->AddSphere(base + Vector3d(reach * std::cos(angle),
                                       reach * std::sin(angle),
                                       0.30 - 0.012 * i),
                       0.075,
                       PatternedMaterial(Pattern::kSpeckle,
                                         Color(0.03, 0.09, 0.02),
                                         Color(0.20, 0.38, 0.09),
                                         0.03,
                                         seed + i));
  }
}

}  // namespace

void AddBookcase(const uint32_t seed, RoomBuilder* builder) {
  constexpr double kWidth = 1.1;
  constexpr double kDepth = 0.30;
  constexpr double kHeight = 1.85;
  constexpr double kBoard = 0.025;
  constexpr int kNumShelves = 5;
  const double x = 0.45;
  const double y = kRoomWidth - kDepth;
  const Material board = PatternedMaterial(Pattern::kWood,
                                           Color(0.62, 0.48, 0.32),
                                           Color(0.42, 0.29, 0.17),
                                           0.06,
                                           seed);
  builder->BeginObject("bookcase", x, y, 0);
  builder->AddBox(
      Vector3d(0, kDepth - 0.01, 0), Vector3d(kWidth, kDepth, kHeight), board);
  builder->AddBox(Vector3d(0, 0, 0), Vector3d(kBoard, kDepth, kHeight), board);
  builder->AddBox(Vector3d(kWidth - kBoard, 0, 0),
                  Vector3d(kWidth, kDepth, kHeight),
                  board);
  const double pitch = (kHeight - 0.06) / kNumShelves;
  for (int i = 0; i <= kNumShelves; ++i) {
    const double z = 0.06 - kBoard + i * pitch;
    builder->AddBox(Vector3d(kBoard, 0, z),
                    Vector3d(kWidth - kBoard, kDepth, z + kBoard),
                    board);
  }
  builder->BeginObject("books", x + kBoard, y, 0);
  for (int i = 0; i < kNumShelves; ++i) {
    AddShelfOfBooks(kWidth - 2 * kBoard,
                    kDepth - 0.02,
                    0.06 + i * pitch,
                    seed + 1000 * (i + 1),
                    builder);
  }
}

void AddSideboard(const uint32_t seed,
                  const bool is_dark_and_glossy,
                  RoomBuilder* builder) {
  constexpr double kWidth = 1.6;
  constexpr double kDepth = 0.45;
  constexpr double kHeight = 0.8;
  constexpr int kNumDoors = 3;
  const double x = 2.05;
  const double y = kRoomWidth - kDepth;
  Material front = PatternedMaterial(Pattern::kWood,
                                     Color(0.55, 0.38, 0.20),
                                     Color(0.26, 0.14, 0.06),
                                     0.07,
                                     seed + 1);
  if (is_dark_and_glossy) {
    front = PlainMaterial(Color(0.012, 0.012, 0.014));
    front.mirror = 0.05;
  }
  builder->BeginObject("sideboard", x, y, 0);
  builder->AddBox(Vector3d(0, 0.02, 0.08),
                  Vector3d(kWidth, kDepth, kHeight),
                  OakMaterial(seed));
  builder->AddBox(Vector3d(0.04, 0.06, 0),
                  Vector3d(kWidth - 0.04, kDepth, 0.08),
                  PlainMaterial(Color(0.05, 0.04, 0.03)));
  builder->BeginObject("sideboard_front", x, y, 0);
  const double door = kWidth / kNumDoors;
  for (int i = 0; i < kNumDoors; ++i) {
    builder->AddBoard(Vector3d((i + 0.5) * door, 0, 0.44),
                      -Vector3d::UnitY(),
                      Vector3d::UnitZ(),
                      door - 0.012,
                      0.69,
                      0.02,
                      front);
  }
  builder->BeginObject("sideboard_things", x, y, 0);
  for (int i = 0; i < kNumDoors; ++i) {
    builder->AddSphere(Vector3d((i + 0.85) * door, -0.012, 0.6),
                       0.014,
                       PlainMaterial(Color(0.55, 0.50, 0.40)));
  }
  AddPlant(Vector3d(0.22, 0.22, kHeight), seed + 20, builder);
  // A reading lamp, a radio and a photograph.
  builder->AddCylinder(Vector3d(1.38, 0.24, kHeight),
                       0.07,
                       0.02,
                       PlainMaterial(Color(0.10, 0.09, 0.08)));
  builder->AddCylinder(Vector3d(1.38, 0.24, kHeight + 0.02),
                       0.012,
                       0.26,
                       PlainMaterial(Color(0.10, 0.09, 0.08)));
  Material shade = PatternedMaterial(Pattern::kFabric,
                                     Color(0.80, 0.66, 0.45),
                                     Color(0.70, 0.55, 0.34),
                                     0.03,
                                     seed + 2);
  shade.emission = 0.25;
  builder->AddCylinder(Vector3d(1.38, 0.24, kHeight + 0.26), 0.11, 0.18, shade);
  builder->AddBox(Vector3d(0.72, 0.16, kHeight),
                  Vector3d(1.08, 0.32, kHeight + 0.2),
                  PatternedMaterial(Pattern::kFabric,
                                    Color(0.10, 0.09, 0.08),
                                    Color(0.32, 0.28, 0.22),
                                    0.035,
                                    seed + 3));
  builder->AddBoard(Vector3d(0.52, 0.26, kHeight + 0.13),
                    Vector3d(0, -1, 0.25),
                    Vector3d::UnitZ(),
                    0.2,
                    0.26,
                    0.015,
                    PatternedMaterial(Pattern::kPicture,
                                      Color(0.60, 0.55, 0.45),
                                      Color(0.15, 0.20, 0.25),
                                      0.08,
                                      seed + 4));
}

void AddArmchair(const uint32_t seed, RoomBuilder* builder) {
  builder->BeginObject("armchair", 4.3, 3.3, 0.75);
  const Material cloth = PatternedMaterial(Pattern::kFabric,
                                           Color(0.10, 0.20, 0.16),
                                           Color(0.36, 0.42, 0.28),
                                           0.05,
                                           seed);
  // It looks along negative y of its own frame.
  builder->AddBox(
      Vector3d(-0.40, -0.38, 0.08), Vector3d(0.40, 0.38, 0.42), cloth);
  builder->AddBox(
      Vector3d(-0.40, 0.22, 0.42), Vector3d(0.40, 0.40, 0.90), cloth);
  builder->AddBox(
      Vector3d(-0.42, -0.40, 0.08), Vector3d(-0.28, 0.38, 0.60), cloth);
  builder->AddBox(
      Vector3d(0.28, -0.40, 0.08), Vector3d(0.42, 0.38, 0.60), cloth);
  builder->AddBoard(Vector3d(0.02, 0.10, 0.60),
                    Vector3d(0.1, -1, 0.35),
                    Vector3d(0.2, 0, 1),
                    0.36,
                    0.36,
                    0.10,
                    PatternedMaterial(Pattern::kCarpet,
                                      Color(0.66, 0.48, 0.14),
                                      Color(0.30, 0.08, 0.05),
                                      0.12,
                                      seed + 1));
}

void AddCrate(const uint32_t seed, RoomBuilder* builder) {
  builder->BeginObject("crate", 0.36, 2.35, -0.2);
  builder->AddBox(Vector3d(-0.26, -0.26, 0),
                  Vector3d(0.26, 0.26, 0.42),
                  PatternedMaterial(Pattern::kWood,
                                    Color(0.58, 0.40, 0.20),
                                    Color(0.28, 0.16, 0.07),
                                    0.09,
                                    seed));
  builder->AddCylinder(Vector3d(0.02, 0, 0.42),
                       0.16,
                       0.22,
                       PatternedMaterial(Pattern::kSpeckle,
                                         Color(0.60, 0.55, 0.48),
                                         Color(0.10, 0.14, 0.28),
                                         0.06,
                                         seed + 1));
}

}  // namespace structnerf::room
