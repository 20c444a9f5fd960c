#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include <Eigen/Core>

namespace structnerf {

// Rays of one tile. A tile is what a thread works on at a time; rays whose
// losses depend on each other are in the same tile.
constexpr int kMaxTileRays = 32;

// Most samples a ray may have.
constexpr int kMaxRaySamples = 64;

template <typename T>
using PerRay = std::array<T, kMaxTileRays>;

// Rays in field coordinates (nerf/scene_frame.h). Directions have length one
// along the camera's z axis, so the ray parameter is z-depth: a sample lies at
// origin + z * direction.
struct RayTile {
  int num_rays = 0;
  PerRay<float> origin[3];
  PerRay<float> direction[3];
  PerRay<float> direction_norm;  // Euclidean length per unit of z-depth
  PerRay<float> near;            // z-depth where sampling starts, > 0
  PerRay<float> far;             // z-depth where it ends, > near

  // The photographs whose appearance colour is to have: the mean of two latent
  // codes (nerf/field/mlp_layout.h), -1 = a code of zeros. Only read if
  // `has_appearance` and by fields with such codes.
  bool has_appearance = false;
  PerRay<int> appearance[2];  // view indices

  // Depth and deviation that training samples also gather around; depth 0 =
  // nowhere. Only read if `is_guided`.
  bool is_guided = false;
  PerRay<float> guide_depth;      // z-depth
  PerRay<float> guide_deviation;  // > 0
};

// What is rendered for the rays of a tile, depth in field units.
struct RayOutputs {
  PerRay<float> color[3];        // in [0, 1]
  PerRay<float> depth;           // expected z-depth
  PerRay<float> depth_variance;  // of the z-depth at which light ends
  PerRay<float> opacity;         // before the last, opaque interval

  Eigen::Vector3f Color(const size_t ray) const {
    return {color[0][ray], color[1][ray], color[2][ray]};
  }
};

// Derivatives of the loss by the outputs, and the quadratic pull of
// nerf/kernels/compositing.h. All zero by default.
struct RayGradients {
  PerRay<float> d_color[3] = {};
  PerRay<float> d_depth = {};
  PerRay<float> d_opacity = {};
  PerRay<float> pull = {};
  PerRay<float> pull_z = {};
};

// How light ends along the rays of a tile, for losses that look at more of a
// ray than its depth. Arrays are ray-major.
struct RaySamples {
  int num_samples = 0;            // n, per ray
  const float* edges = nullptr;   // rays x (n + 1), z-depth, ascending
  const float* weight = nullptr;  // rays x n, share of the light that ends in
                                  // each interval; sums to one
};

}  // namespace structnerf
