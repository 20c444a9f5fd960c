#pragma once

namespace structnerf {

// Four pixels of one planar superpixel, for the coplanarity loss. The inverse
// depth of a plane is affine in the pixel coordinates of a pinhole camera, so
// with barycentric coordinates b of the fourth pixel in the triangle of the
// first three, rho_3 = b_0 rho_0 + b_1 rho_1 + b_2 rho_2. This is linear, free
// of scale and cannot degenerate, unlike the paper's triple product (eq. 11),
// which is cubic in depth.
struct PlanarGroup {
  float barycentric[3] = {0, 0, 0};
};

// Barycentric coordinates of pixel 3; false if the triangle is too thin or the
// pixel too far outside for a stable prediction (|b| > 2).
bool MakePlanarGroup(const float* x, const float* y, PlanarGroup* group);

// Huber loss of r = (rho_3 - sum_k b_k rho_k) / mean(rho), quadratic up to 1 %,
// divided by that 1 % so that its slope is at most 1. Writes derivatives by the
// four depths. All depths must be positive.
float EvaluatePlanarLoss(const PlanarGroup& group,
                         const float* depth,
                         float* d_depth);

}  // namespace structnerf
