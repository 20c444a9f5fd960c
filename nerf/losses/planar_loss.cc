#include "nerf/losses/planar_loss.h"

#include <cmath>

namespace structnerf {
namespace {

constexpr float kMaxBarycentric = 2.0f;
constexpr float kMinSine = 0.1f;
constexpr float kHuberDelta = 0.01f;

}  // namespace

bool MakePlanarGroup(const float* x, const float* y, PlanarGroup* group) {
  const float ux = x[1] - x[0];
  const float uy = y[1] - y[0];
  const float vx = x[2] - x[0];
  const float vy = y[2] - y[0];
  const float wx = x[3] - x[0];
  const float wy = y[3] - y[0];
  const float area = ux * vy - uy * vx;
  const float lengths = std::sqrt((ux * ux + uy * uy) * (vx * vx + vy * vy));
  if (!(std::abs(area) > kMinSine * lengths)) {
    return false;
  }
  group->barycentric[1] = (wx * vy - wy * vx) / area;
  group->barycentric[2] = (ux * wy - uy * wx) / area;
  group->barycentric[0] = 1 - group->barycentric[1] - group->barycentric[2];
  for (const float b : group->barycentric) {
    if (std::abs(b) > kMaxBarycentric) {
      return false;
    }
  }
  return true;
}

float EvaluatePlanarLoss(const PlanarGroup& group,
                         const float* depth,
                         float* d_depth) {
  float rho[4];
  float mean = 0;
  for (int i = 0; i < 4; ++i) {
    rho[i] = 1.0f / depth[i];
    mean += 0.25f * rho[i];
  }
  float difference = rho[3];
  for (int i = 0; i < 3; ++i) {
    difference -= group.barycentric[i] * rho[i];
  }
  const float residual = difference / mean;
  const float absolute = std::abs(residual);
  const bool is_quadratic = absolute < kHuberDelta;
  const float loss = is_quadratic ? 0.5f * residual * residual / kHuberDelta
                                  : absolute - 0.5f * kHuberDelta;
  const float d_residual =
      is_quadratic ? residual / kHuberDelta : std::copysign(1.0f, residual);
  for (int i = 0; i < 4; ++i) {
    const float coefficient = i == 3 ? 1.0f : -group.barycentric[i];
    const float d_rho = d_residual * (coefficient - 0.25f * residual) / mean;
    d_depth[i] = -rho[i] * (rho[i] * d_rho);
  }
  return loss;
}

}  // namespace structnerf
