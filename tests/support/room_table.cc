#include "tests/support/room_furniture.h"

#include <cmath>

namespace structnerf::room {
namespace {

using Eigen::Vector3d;
using Pattern = Material::Pattern;

void AddTableware(const uint32_t seed, RoomBuilder* builder) {
  constexpr double kTop = 0.75;
  builder->AddCylinder(Vector3d(-0.45, 0.12, kTop),
                       0.07,
                       0.03,
                       PlainMaterial(Color(0.1, 0.07, 0.05)));
  builder->AddSphere(Vector3d(-0.45, 0.12, kTop + 0.16),
                     0.135,
                     PatternedMaterial(Pattern::kNoise,
                                       Color(0.05, 0.16, 0.42),
                                       Color(0.55, 0.52, 0.22),
                                       0.16,
                                       seed));
  builder->AddCylinder(Vector3d(0.48, 0.18, kTop),
                       0.055,
                       0.26,
                       PatternedMaterial(Pattern::kStripes,
                                         Color(0.65, 0.60, 0.50),
                                         Color(0.10, 0.22, 0.25),
                                         0.035,
                                         seed + 1));
  builder->AddBox(Vector3d(-0.12, -0.10, kTop),
                  Vector3d(0.24, 0.16, kTop + 0.02),
                  PatternedMaterial(Pattern::kChecker,
                                    Color(0.75, 0.70, 0.60),
                                    Color(0.12, 0.06, 0.04),
                                    0.045,
                                    seed));
  builder->AddBox(Vector3d(-0.40, -0.32, kTop),
                  Vector3d(-0.14, -0.13, kTop + 0.035),
                  PatternedMaterial(Pattern::kPicture,
                                    Color(0.55, 0.12, 0.08),
                                    Color(0.70, 0.50, 0.15),
                                    0.09,
                                    seed + 2));
  builder->AddBox(Vector3d(-0.38, -0.30, kTop + 0.035),
                  Vector3d(-0.18, -0.15, kTop + 0.065),
                  PatternedMaterial(Pattern::kPicture,
                                    Color(0.10, 0.25, 0.45),
                                    Color(0.60, 0.60, 0.55),
                                    0.07,
                                    seed + 3));
  builder->AddCylinder(Vector3d(0.42, -0.18, kTop),
                       0.12,
                       0.05,
                       PatternedMaterial(Pattern::kSpeckle,
                                         Color(0.55, 0.50, 0.45),
                                         Color(0.25, 0.20, 0.18),
                                         0.03,
                                         seed + 4));
  for (int i = 0; i < 4; ++i) {
    const double angle = 1.6 * i;
    builder->AddSphere(Vector3d(0.42 + 0.055 * std::cos(angle),
                                -0.18 + 0.055 * std::sin(angle),
                                kTop + 0.08),
                       0.042,
                       PatternedMaterial(Pattern::kNoise,
                                         Color(0.75, 0.30, 0.04),
                                         Color(0.45, 0.42, 0.05),
                                         0.05,
                                         seed + 5 + i));
  }
}

}  // namespace

void AddTable(const uint32_t seed, RoomBuilder* builder) {
  constexpr double kX = 2.7;
  constexpr double kY = 2.15;
  constexpr double kYaw = 0.12;
  builder->BeginObject("rug", kX - 0.1, kY - 0.1, -0.05);
  builder->AddBox(Vector3d(-1.15, -0.8, 0),
                  Vector3d(1.15, 0.8, 0.01),
                  PatternedMaterial(Pattern::kCarpet,
                                    Color(0.36, 0.07, 0.05),
                                    Color(0.62, 0.50, 0.32),
                                    0.32,
                                    seed));
  builder->BeginObject("table", kX, kY, kYaw);
  builder->AddBox(Vector3d(-0.75, -0.42, 0.71),
                  Vector3d(0.75, 0.42, 0.75),
                  OakMaterial(seed + 1));
  builder->AddLegs(0.70, 0.37, 0.06, 0.71, OakMaterial(seed + 2));
  builder->BeginObject("tableware", kX, kY, kYaw);
  AddTableware(seed + 3, builder);
}

void AddChair(const uint32_t seed, const bool has_slats, RoomBuilder* builder) {
  constexpr double kHalf = 0.21;
  builder->BeginObject("chair", 1.75, 1.62, 0.45);
  const Material wood = PatternedMaterial(Pattern::kWood,
                                          Color(0.36, 0.20, 0.10),
                                          Color(0.16, 0.08, 0.04),
                                          0.05,
                                          seed);
  builder->AddLegs(kHalf, kHalf, 0.035, 0.45, wood);
  // The back stands at negative x, towards the walk's beginning.
  for (const double y : {-kHalf, kHalf - 0.035}) {
    builder->AddBox(Vector3d(-kHalf, y, 0.45),
                    Vector3d(-kHalf + 0.035, y + 0.035, 0.95),
                    wood);
  }
  if (!has_slats) {
    const Material cloth = PatternedMaterial(Pattern::kFabric,
                                             Color(0.08, 0.14, 0.20),
                                             Color(0.38, 0.40, 0.36),
                                             0.04,
                                             seed + 1);
    builder->AddBox(
        Vector3d(-kHalf, -kHalf, 0.45), Vector3d(kHalf, kHalf, 0.49), cloth);
    builder->AddBox(Vector3d(-kHalf + 0.005, -kHalf + 0.035, 0.58),
                    Vector3d(-kHalf + 0.03, kHalf - 0.035, 0.93),
                    cloth);
    return;
  }
  constexpr int kNumSlats = 6;
  constexpr double kSlatWidth = 0.018;
  for (int i = 0; i < kNumSlats; ++i) {
    const double y =
        -kHalf + 0.035 + (i + 0.5) * (2 * kHalf - 0.07) / kNumSlats;
    builder->AddBox(Vector3d(-kHalf + 0.01, y - 0.5 * kSlatWidth, 0.47),
                    Vector3d(-kHalf + 0.025, y + 0.5 * kSlatWidth, 0.92),
                    wood);
    builder->AddBox(Vector3d(-kHalf, y - 0.5 * kSlatWidth, 0.455),
                    Vector3d(kHalf, y + 0.5 * kSlatWidth, 0.47),
                    wood);
  }
  builder->AddBox(Vector3d(-kHalf, -kHalf, 0.92),
                  Vector3d(-kHalf + 0.03, kHalf, 0.95),
                  wood);
}

}  // namespace structnerf::room
