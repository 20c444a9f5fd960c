#pragma once

#include "nerf/scene.h"

#include <vector>

#include <Eigen/Core>

namespace structnerf::room {

// Image points (pixel centres) where the grey values change in all directions:
// the smaller eigenvalue of the gradients' covariance over 5 x 5 pixels, in
// squared grey levels per pixel, is at least `min_response` and the largest
// within `radius` pixels. Strongest first, none closer to the border than
// `radius` + 3.
std::vector<Eigen::Vector2d> DetectCorners(const RgbImage& image,
                                           double min_response,
                                           int radius);

}  // namespace structnerf::room
