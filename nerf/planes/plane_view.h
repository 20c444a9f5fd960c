#pragma once

#include "nerf/scene.h"

#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

namespace structnerf {

// One view at training resolution as planes are looked for in it: what matching
// found, and how sure that is.
struct PlaneView {
  int width = 0;
  int height = 0;
  PinholeCamera camera;  // of the training image

  // Inverse depth (field units) at pixel centres, not positive = none.
  // Row-major.
  std::vector<float> rho;

  // Whether a pixel matches clearly better at its depth than nearby, and later,
  // whether other views confirm it too.
  std::vector<uint8_t> is_reliable;

  // Label of each pixel's superpixel or -1, masked pixels -1; empty where there
  // are no superpixels.
  std::vector<int32_t> segments;

  size_t Index(const int col, const int row) const {
    return static_cast<size_t>(row) * width + col;
  }

  // Ray of unit z-depth through a pixel's centre, camera frame.
  Eigen::Vector3f Ray(const int col, const int row) const {
    return {static_cast<float>((col + 0.5 - camera.cx) / camera.fx),
            static_cast<float>((row + 0.5 - camera.cy) / camera.fy),
            1.0f};
  }
};

// A plane in the camera frame of a view: its inverse depth (field units) along
// a ray of unit z-depth is the product of both, since inverse depth is affine
// in a pinhole's image coordinates.
struct PlaneHypothesis {
  Eigen::Vector3f coefficients = Eigen::Vector3f::Zero();

  // Share of the reliable pixels in and around the segment that lie on it.
  float support = 0;

  float InverseDepth(const Eigen::Vector3f& ray) const {
    return coefficients.dot(ray);
  }
};

}  // namespace structnerf
