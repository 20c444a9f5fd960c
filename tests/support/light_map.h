#pragma once

#include "tests/support/ray_caster.h"

#include <vector>

#include <Eigen/Core>

namespace structnerf::room {

// A rectangle that shines to the side of half_u x half_v.
struct AreaLight {
  Eigen::Vector3d center;
  Eigen::Vector3d half_u;
  Eigen::Vector3d half_v;
  Color radiance;
};

struct Lighting {
  std::vector<AreaLight> lights;
  // Light that has been reflected so often that it comes from everywhere, on
  // surfaces that face up and down. Narrow places get less of it.
  Color ambient_from_above = Color::Zero();
  Color ambient_from_below = Color::Zero();
};

// Light arriving on every surface, computed once at vertices a few centimetres
// apart and interpolated between them. It does not depend on the viewer and has
// no noise, so a blank wall stays blank.
class LightMap {
 public:
  LightMap(const RayCaster& caster, const Lighting& lighting);

  // Linear light at a hit, 1 = a white surface is white in the image.
  Color Irradiance(const Hit& hit) const;

 private:
  struct Face {
    int primitive_idx = 0;
    int face = 0;
    int width = 0;   // vertices along u
    int height = 0;  // vertices along v
    std::vector<Color> vertices;
  };

  std::vector<Face> faces_;
  std::vector<int> first_face_;  // into faces_, by primitive
};

}  // namespace structnerf::room
