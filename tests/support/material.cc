#include "tests/support/material.h"

#include "tests/support/value_noise.h"

#include <algorithm>
#include <cmath>

namespace structnerf::room {
namespace {

double SmoothStep(const double low, const double high, const double x) {
  const double t = std::clamp((x - low) / (high - low), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

int Cell(const double x) { return static_cast<int>(std::floor(x)); }

Color Mix(const Material& material, const double share_of_b) {
  return material.color_a + share_of_b * (material.color_b - material.color_a);
}

double Speckle(const Material& material, const Eigen::Vector3d& local) {
  const Eigen::Vector3d p = local / material.size;
  const double coarse = SmoothStep(0.45, 0.55, ValueNoise(p, material.seed));
  const double fine =
      SmoothStep(0.4, 0.6, ValueNoise(2.7 * p, material.seed + 1));
  return 0.6 * coarse + 0.4 * fine;
}

double Wood(const Material& material, const Eigen::Vector3d& local) {
  const Eigen::Vector3d p = local / material.size;
  const Eigen::Vector3d grain(0.12 * p.x(), p.y(), p.z());
  const double rings = FractalNoise(1.3 * grain, 3, 0.6, material.seed);
  const double fibers =
      ValueNoise(Eigen::Vector3d(0.9 * p.x(), 3.5 * p.y(), 3.5 * p.z()),
                 material.seed + 7);
  const double spots = ValueNoise(0.8 * p, material.seed + 8);
  return 0.45 * SmoothStep(0.3, 0.7, rings) +
         0.35 * SmoothStep(0.3, 0.8, fibers) + 0.2 * spots;
}

double Planks(const Material& material, const Eigen::Vector3d& local) {
  constexpr double kLength = 1.1;  // metres
  constexpr double kGap = 0.004;   // metres
  const int row = Cell(local.y() / material.size);
  const double x =
      local.x() + kLength * HashedUniform(row, 0, 0, material.seed);
  const int column = Cell(x / kLength);
  const double across = local.y() - row * material.size;
  const double along = x - column * kLength;
  if (across < kGap || along < kGap) {
    return 1;
  }
  const Eigen::Vector3d grain(1.5 * x, 25 * local.y(), column);
  return 0.45 * HashedUniform(row, column, 1, material.seed) +
         0.35 * FractalNoise(grain, 2, 0.5, material.seed + 3);
}

double Fabric(const Material& material, const Eigen::Vector3d& local) {
  const Eigen::Vector3d p = local * (M_PI / material.size);
  const double threads =
      0.5 + 0.25 * (std::sin(p.x() + p.z()) + std::sin(p.y() - p.z()));
  const double clouds =
      FractalNoise(local / (1.5 * material.size), 2, 0.7, material.seed);
  return 0.35 * threads + 0.65 * SmoothStep(0.25, 0.75, clouds);
}

Color Stripes(const Material& material, const Eigen::Vector3d& local) {
  const double z = local.z() / material.size;
  const int band = Cell(z);
  const double kind = HashedUniform(band, 0, 0, material.seed);
  const double wear =
      ValueNoise(local / (0.6 * material.size), material.seed + 5);
  // Some bands carry letters: a row of blocks along the surface.
  const double ink =
      kind > 0.6
          ? SmoothStep(
                0.45, 0.55, ValueNoise(local / (0.5 * material.size), band))
          : SmoothStep(0.25, 0.35, kind);
  return Mix(material, ink) * (0.85 + 0.3 * wear);
}

Color Picture(const Material& material, const Eigen::Vector3d& local) {
  const Eigen::Vector3d p = local / material.size;
  Color color =
      Mix(material,
          SmoothStep(0.25, 0.75, FractalNoise(0.7 * p, 4, 0.6, material.seed)));
  // At most one disc or square per cell and layer; later layers are smaller and
  // lie on top.
  for (int layer = 0; layer < 3; ++layer) {
    const double scale = 0.5 * (1 << layer);
    const uint32_t seed = material.seed + 11 * (layer + 1);
    const int cell_x = Cell(scale * p.x());
    const int cell_y = Cell(scale * p.y());
    const auto uniform = [&](const int what) {
      return HashedUniform(cell_x, cell_y, what, seed);
    };
    const double radius = 0.15 + 0.3 * uniform(4);
    const double room = 0.5 - radius;
    const double dx =
        scale * p.x() - cell_x - 0.5 - room * (2 * uniform(5) - 1);
    const double dy =
        scale * p.y() - cell_y - 0.5 - room * (2 * uniform(6) - 1);
    const double distance = uniform(7) < 0.5
                                ? std::hypot(dx, dy)
                                : std::max(std::abs(dx), std::abs(dy)) * 1.15;
    if (uniform(8) < 0.6 && distance < radius) {
      const Color paint = 0.4 * Mix(material, uniform(9)) +
                          0.6 * Color(uniform(1), uniform(2), uniform(3));
      color = (0.35 + 0.9 * ValueNoise(2.5 * p, seed)) * paint;
    }
  }
  return color;
}

double Carpet(const Material& material, const Eigen::Vector3d& local) {
  const double u = local.x() / material.size;
  const double v = local.y() / material.size;
  const double lozenge =
      std::abs(u - std::round(u)) + std::abs(v - std::round(v));
  const double ornament = SmoothStep(0.1, 0.16, std::abs(lozenge - 0.35));
  const double pile =
      FractalNoise(local / (0.25 * material.size), 2, 0.7, material.seed);
  return 0.5 * ornament + 0.5 * SmoothStep(0.2, 0.8, pile);
}

}  // namespace

Material PlainMaterial(const Color& color) {
  return {Material::Pattern::kPlain, color};
}

Material PatternedMaterial(const Material::Pattern pattern,
                           const Color& color_a,
                           const Color& color_b,
                           const double size,
                           const uint32_t seed) {
  return {pattern, color_a, color_b, size, seed};
}

Material OakMaterial(const uint32_t seed) {
  return {Material::Pattern::kWood,
          Color(0.50, 0.31, 0.15),
          Color(0.20, 0.10, 0.045),
          0.055,
          seed};
}

Color Reflectance(const Material& material, const Eigen::Vector3d& local) {
  switch (material.pattern) {
    case Material::Pattern::kPlain:
      return material.color_a;
    case Material::Pattern::kNoise:
      return Mix(material,
                 SmoothStep(0.2,
                            0.8,
                            FractalNoise(
                                local / material.size, 4, 0.7, material.seed)));
    case Material::Pattern::kSpeckle:
      return Mix(material, Speckle(material, local));
    case Material::Pattern::kChecker: {
      // Off the faces, where rounding would choose the cube.
      const Eigen::Vector3d p = local / material.size;
      const int sum =
          Cell(p.x() + 1e-6) + Cell(p.y() + 1e-6) + Cell(p.z() + 1e-6);
      return Mix(material, sum & 1);
    }
    case Material::Pattern::kWood:
      return Mix(material, Wood(material, local));
    case Material::Pattern::kPlanks:
      return Mix(material, Planks(material, local));
    case Material::Pattern::kFabric:
      return Mix(material, Fabric(material, local));
    case Material::Pattern::kStripes:
      return Stripes(material, local);
    case Material::Pattern::kPicture:
      return Picture(material, local);
    case Material::Pattern::kCarpet:
      return Mix(material, Carpet(material, local));
  }
  return material.color_a;
}

}  // namespace structnerf::room
