#include "tests/support/light_map.h"

#include "tests/support/parallel_for.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Geometry>

namespace structnerf::room {
namespace {

constexpr double kVertexDistance = 0.09;  // metres
constexpr int kLightSamples = 5;          // per side of a light
constexpr int kNumAmbientRays = 40;
constexpr double kAmbientReach = 0.9;  // metres
constexpr double kOffset = 1e-4;       // metres, off the surface

Color DirectLight(const RayCaster& caster,
                  const AreaLight& light,
                  const Eigen::Vector3d& position,
                  const Eigen::Vector3d& normal) {
  const Eigen::Vector3d cross = 4 * light.half_u.cross(light.half_v);
  const double sample_area = cross.norm() / (kLightSamples * kLightSamples);
  const Eigen::Vector3d light_normal = cross.normalized();
  double sum = 0;
  for (int i = 0; i < kLightSamples; ++i) {
    for (int j = 0; j < kLightSamples; ++j) {
      const double a = (2 * i + 1.0) / kLightSamples - 1;
      const double b = (2 * j + 1.0) / kLightSamples - 1;
      const Eigen::Vector3d target =
          light.center + a * light.half_u + b * light.half_v;
      const Eigen::Vector3d to_light = target - position;
      const double distance = to_light.norm();
      const double cos_here = normal.dot(to_light) / distance;
      const double cos_there = -light_normal.dot(to_light) / distance;
      if (cos_here > 0 && cos_there > 0 &&
          !caster.IsOccluded(position, target, 1e-3)) {
        sum += cos_here * cos_there * sample_area / (distance * distance);
      }
    }
  }
  return light.radiance * (sum / M_PI);
}

// Directions around +z, denser towards it by their cosine.
std::array<Eigen::Vector3d, kNumAmbientRays> AmbientDirections() {
  std::array<Eigen::Vector3d, kNumAmbientRays> directions;
  const double golden_angle = M_PI * (3 - std::sqrt(5.0));
  for (int i = 0; i < kNumAmbientRays; ++i) {
    const double radius = std::sqrt((i + 0.5) / kNumAmbientRays);
    directions[i] = Eigen::Vector3d(radius * std::cos(i * golden_angle),
                                    radius * std::sin(i * golden_angle),
                                    std::sqrt(1 - radius * radius));
  }
  return directions;
}

// Share of the ambient light that reaches a point: things nearby block it,
// things far away reflect as much as they block.
double AmbientShare(const RayCaster& caster,
                    const Eigen::Vector3d& position,
                    const Eigen::Vector3d& normal) {
  static const auto directions = AmbientDirections();
  const Eigen::Vector3d tangent = normal.unitOrthogonal();
  const Eigen::Vector3d bitangent = normal.cross(tangent);
  double blocked = 0;
  for (const Eigen::Vector3d& direction : directions) {
    const Ray ray{position,
                  direction.x() * tangent + direction.y() * bitangent +
                      direction.z() * normal};
    Hit hit;
    if (caster.Cast(ray, &hit) && hit.surface.t < kAmbientReach) {
      const double nearness = 1 - hit.surface.t / kAmbientReach;
      blocked += nearness * nearness;
    }
  }
  return 1 - 0.85 * blocked / kNumAmbientRays;
}

Color LightAt(const RayCaster& caster,
              const Lighting& lighting,
              const Eigen::Vector3d& position,
              const Eigen::Vector3d& normal) {
  const double up = 0.5 + 0.5 * normal.z();
  Color light = (up * lighting.ambient_from_above +
                 (1 - up) * lighting.ambient_from_below) *
                AmbientShare(caster, position, normal);
  for (const AreaLight& area_light : lighting.lights) {
    light += DirectLight(caster, area_light, position, normal);
  }
  return light;
}

int NumVertices(const double size) {
  return 2 + static_cast<int>(size / kVertexDistance);
}

}  // namespace

LightMap::LightMap(const RayCaster& caster, const Lighting& lighting) {
  const std::vector<Primitive>& primitives = caster.Primitives();
  for (size_t i = 0; i < primitives.size(); ++i) {
    first_face_.push_back(static_cast<int>(faces_.size()));
    for (int face = 0; face < NumFaces(primitives[i]); ++face) {
      const Eigen::Vector2d size = FaceSize(primitives[i], face);
      const int width = NumVertices(size.x());
      const int height = NumVertices(size.y());
      faces_.push_back({static_cast<int>(i),
                        face,
                        width,
                        height,
                        std::vector<Color>(width * height)});
    }
  }
  ParallelFor(static_cast<int>(faces_.size()), [&](const int face_idx) {
    Face& face = faces_[face_idx];
    const Primitive& primitive = primitives[face.primitive_idx];
    for (int row = 0; row < face.height; ++row) {
      for (int col = 0; col < face.width; ++col) {
        Eigen::Vector3d position;
        Eigen::Vector3d normal;
        // Not on the very edge, where a neighbour would swallow the vertex.
        const Eigen::Vector2d uv(col / (face.width - 1.0),
                                 row / (face.height - 1.0));
        FacePoint(primitive,
                  face.face,
                  0.98 * uv + Eigen::Vector2d::Constant(0.01),
                  &position,
                  &normal);
        face.vertices[row * face.width + col] =
            LightAt(caster, lighting, position + kOffset * normal, normal);
      }
    }
  });
}

Color LightMap::Irradiance(const Hit& hit) const {
  const Face& face = faces_[first_face_[hit.primitive_idx] + hit.surface.face];
  const double u = std::clamp(hit.surface.uv.x(), 0.0, 1.0) * (face.width - 1);
  const double v = std::clamp(hit.surface.uv.y(), 0.0, 1.0) * (face.height - 1);
  const int col = std::min(static_cast<int>(u), face.width - 2);
  const int row = std::min(static_cast<int>(v), face.height - 2);
  const double s = u - col;
  const double t = v - row;
  const Color* corner = &face.vertices[row * face.width + col];
  return (1 - t) * ((1 - s) * corner[0] + s * corner[1]) +
         t * ((1 - s) * corner[face.width] + s * corner[face.width + 1]);
}

}  // namespace structnerf::room
