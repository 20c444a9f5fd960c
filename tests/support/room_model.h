#pragma once

#include "tests/support/light_map.h"
#include "tests/support/ray_caster.h"
#include "tests/support/synthetic_room.h"

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace structnerf::room {

// Shapes, materials and light of the furnished room, in metres; x east, y
// north, z up, the origin in a corner of the floor.
class RoomModel {
 public:
  RoomModel(RoomFault fault, int seed);

  const RayCaster& Caster() const { return *caster_; }

  // Linear light that a ray collects; black outside the room.
  Color Radiance(const Ray& ray) const;

  const std::string& ObjectName(const Hit& hit) const;

  // Whether a surface has features that can be matched between views: it is
  // neither blank nor a mirror.
  bool IsMatchable(const Hit& hit) const;

  // Whether a surface is what the room's fault is about.
  bool IsFaulty(const Hit& hit) const;

 private:
  Color SurfaceRadiance(const Hit& hit) const;

  std::vector<std::string> objects_;
  std::string faulty_object_;
  std::unique_ptr<RayCaster> caster_;
  std::unique_ptr<LightMap> light_map_;
};

}  // namespace structnerf::room
