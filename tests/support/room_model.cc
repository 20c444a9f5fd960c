#include "tests/support/room_model.h"

#include "tests/support/room_builder.h"
#include "tests/support/room_furniture.h"

#include <cmath>

namespace structnerf::room {
namespace {

RoomBuilder Furnish(const RoomFault fault, const uint32_t seed) {
  RoomBuilder builder;
  AddShell(seed, &builder);
  AddTable(seed + 10000, &builder);
  AddChair(seed + 20000, fault == RoomFault::kChairSlats, &builder);
  AddBookcase(seed + 30000, &builder);
  AddSideboard(seed + 40000, fault == RoomFault::kDarkGlossyFront, &builder);
  AddPosters(seed + 50000, &builder);
  if (fault == RoomFault::kObjectAndWallOneSegment) {
    AddBlankBoard(&builder);
  } else {
    AddArmchair(seed + 60000, &builder);
  }
  AddCrate(seed + 70000, &builder);
  AddLamp(&builder);
  return builder;
}

std::string FaultyObject(const RoomFault fault) {
  switch (fault) {
    case RoomFault::kDarkGlossyFront:
      return "sideboard_front";
    case RoomFault::kBlankWallTwoViews:
      return "wall_south";
    case RoomFault::kChairSlats:
      return "chair";
    case RoomFault::kObjectAndWallOneSegment:
      return "blank_board";
    case RoomFault::kWrongPointCluster:
      return "poster_north";
    case RoomFault::kNone:
    case RoomFault::kExposureJump:
      break;
  }
  return "";
}

// Daylight from the window in the east, the lamp above the table, and what the
// walls send back.
Lighting RoomLighting() {
  using Eigen::Vector3d;
  Lighting lighting;
  lighting.lights.push_back({Vector3d(kRoomLength - 0.04, 1.0, 1.55),
                             Vector3d(0, 0, 0.65),
                             Vector3d(0, 0.70, 0),
                             Color(10.5, 11.2, 12.0)});
  lighting.lights.push_back({Vector3d(2.7, 2.15, 1.94),
                             Vector3d(0, 0.18, 0),
                             Vector3d(0.18, 0, 0),
                             Color(20.0, 17.0, 12.5)});
  lighting.ambient_from_above = Color(0.36, 0.36, 0.36);
  lighting.ambient_from_below = Color(0.50, 0.46, 0.41);
  return lighting;
}

}  // namespace

RoomModel::RoomModel(const RoomFault fault, const int seed)
    : faulty_object_(FaultyObject(fault)) {
  const RoomBuilder builder =
      Furnish(fault, static_cast<uint32_t>(seed) * 1000003u);
  objects_ = builder.Objects();
  caster_ = std::make_unique<RayCaster>(builder.Primitives());
  light_map_ = std::make_unique<LightMap>(*caster_, RoomLighting());
}

Color RoomModel::SurfaceRadiance(const Hit& hit) const {
  const Material& material = caster_->Primitives()[hit.primitive_idx].material;
  const Color light = light_map_->Irradiance(hit).array() + material.emission;
  return light.cwiseProduct(Reflectance(material, hit.surface.local));
}

Color RoomModel::Radiance(const Ray& ray) const {
  Hit hit;
  if (!caster_->Cast(ray, &hit)) {
    return Color::Zero();
  }
  Color radiance = SurfaceRadiance(hit);
  const double mirror =
      caster_->Primitives()[hit.primitive_idx].material.mirror;
  if (mirror > 0) {
    const Eigen::Vector3d direction = ray.direction.normalized();
    const Eigen::Vector3d& normal = hit.surface.normal;
    const double cosine = -normal.dot(direction);
    // Schlick's approximation of Fresnel's law.
    const double share = mirror + (1 - mirror) * std::pow(1 - cosine, 5);
    const Ray reflected{
        ray.origin + hit.surface.t * ray.direction + 1e-6 * normal,
        direction + 2 * cosine * normal};
    Hit reflected_hit;
    if (caster_->Cast(reflected, &reflected_hit)) {
      radiance =
          (1 - share) * radiance + share * SurfaceRadiance(reflected_hit);
    }
  }
  return radiance;
}

const std::string& RoomModel::ObjectName(const Hit& hit) const {
  return objects_[caster_->Primitives()[hit.primitive_idx].object_idx];
}

bool RoomModel::IsMatchable(const Hit& hit) const {
  const Material& material = caster_->Primitives()[hit.primitive_idx].material;
  return material.pattern != Material::Pattern::kPlain && material.mirror == 0;
}

bool RoomModel::IsFaulty(const Hit& hit) const {
  return ObjectName(hit) == faulty_object_;
}

}  // namespace structnerf::room
