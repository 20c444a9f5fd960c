#pragma once

#include <cstdint>

#include <Eigen/Core>

namespace structnerf::room {

// Colours are linear RGB reflectances in [0, 1].
using Color = Eigen::Vector3d;

// How a surface reflects. The pattern mixes two colours by the position in the
// primitive's local frame, so it is continuous around edges.
struct Material {
  enum class Pattern {
    kPlain,    // color_a only
    kNoise,    // clouds, finest detail an eighth of `size`
    kSpeckle,  // noise of two scales with hard steps, like terrazzo or foliage
    kChecker,  // cubes of side `size`
    kWood,     // grain along local x, rings `size` apart
    kPlanks,   // floor boards along local x, `size` wide
    kFabric,   // threads `size` apart across each other, with irregularities
    kStripes,  // bands across local z of mean height `size`
    kPicture,  // coloured shapes of about `size` on a ground
    kCarpet,   // ornament of lozenges with period `size`, with borders
  };

  Pattern pattern = Pattern::kPlain;
  Color color_a = Color::Constant(0.5);
  Color color_b = Color::Constant(0.5);
  double size = 0.1;  // metres
  uint32_t seed = 0;

  // Share of light that is reflected as by a mirror, seen perpendicularly.
  double mirror = 0;

  // Light that the surface itself sends out, linear, 1 = white in the image.
  double emission = 0;
};

Material PlainMaterial(const Color& color);

Material PatternedMaterial(Material::Pattern pattern,
                           const Color& color_a,
                           const Color& color_b,
                           double size,
                           uint32_t seed);

Material OakMaterial(uint32_t seed);

// Linear reflectance at a point of the local frame, in metres.
Color Reflectance(const Material& material, const Eigen::Vector3d& local);

}  // namespace structnerf::room
