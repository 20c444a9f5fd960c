#include "nerf/extract/normal_estimation.h"

#include "nerf/extract/map_resolution.h"
#include "nerf/watched_loop.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

namespace structnerf {
namespace {

// Half the side of the window, and the distance of the pixels that are read, in
// maps of the reference size.
constexpr int kWindowRadius = 6;
constexpr int kWindowStep = 2;

// Neighbours count by 1 / (1 + (relative difference in depth / this)^4).
constexpr float kDepthFalloff = 0.03f;

void EstimateRow(const PinholeCamera& camera, const int row, DenseMaps* maps) {
  const int width = maps->width;
  const int height = maps->height;
  const size_t num_pixels = static_cast<size_t>(width) * height;
  const int unit = WholePixelsPerReferencePixel(camera);
  const int radius = kWindowRadius * unit;
  const int step = kWindowStep * unit;
  const float inverse_fx = static_cast<float>(1.0 / camera.fx);
  const float inverse_fy = static_cast<float>(1.0 / camera.fy);
  for (int col = 0; col < width; ++col) {
    const size_t index = static_cast<size_t>(row) * width + col;
    const float depth = maps->depth[index];
    if (depth <= 0) {
      continue;
    }
    // In units of the centre's inverse depth and relative to the centre
    // pixel, so that single precision is enough at any scale.
    float xx = 0, xy = 0, yy = 0, x1 = 0, y1 = 0, n = 0;
    float xr = 0, yr = 0, r1 = 0;
    for (int dy = -radius; dy <= radius; dy += step) {
      const int other_row = row + dy;
      if (other_row < 0 || other_row >= height) {
        continue;
      }
      for (int dx = -radius; dx <= radius; dx += step) {
        const int other_col = col + dx;
        if (other_col < 0 || other_col >= width) {
          continue;
        }
        const float other =
            maps->depth[static_cast<size_t>(other_row) * width + other_col];
        if (other <= 0) {
          continue;
        }
        const float ratio = depth / other;
        const float difference = (ratio - 1.0f) * (1.0f / kDepthFalloff);
        const float weight =
            1.0f / (1.0f + difference * difference * difference * difference);
        const float x = static_cast<float>(dx);
        const float y = static_cast<float>(dy);
        xx += weight * x * x;
        xy += weight * x * y;
        yy += weight * y * y;
        x1 += weight * x;
        y1 += weight * y;
        n += weight;
        xr += weight * x * (ratio - 1.0f);
        yr += weight * y * (ratio - 1.0f);
        r1 += weight * (ratio - 1.0f);
      }
    }
    Eigen::Matrix3f a;
    a << xx, xy, x1, xy, yy, y1, x1, y1, n;
    // A trace of regularisation makes an isolated pixel face the camera.
    a(0, 0) += 1e-3f;
    a(1, 1) += 1e-3f;
    const Eigen::Vector3f fit = a.ldlt().solve(Eigen::Vector3f(xr, yr, r1));
    // rho / rho_center = 1 + fit.z + fit.x dx + fit.y dy in pixels.
    const float by_x = fit.x() / inverse_fx;
    const float by_y = fit.y() / inverse_fy;
    const float ray_x = (static_cast<float>(col - camera.cx)) * inverse_fx;
    const float ray_y = (static_cast<float>(row - camera.cy)) * inverse_fy;
    const float at_origin = 1.0f + fit.z() - by_x * ray_x - by_y * ray_y;
    Eigen::Vector3f normal(-by_x, -by_y, -at_origin);
    const float norm = normal.norm();
    if (!(norm > 0) || !std::isfinite(norm) ||
        normal.dot(Eigen::Vector3f(ray_x, ray_y, 1.0f)) >= 0) {
      normal = -Eigen::Vector3f(ray_x, ray_y, 1.0f).normalized();
    } else {
      normal /= norm;
    }
    for (int i = 0; i < 3; ++i) {
      maps->normal[i * num_pixels + index] = normal[i];
    }
  }
}

void ClearNormals(DenseMaps* maps) {
  maps->normal.assign(3 * static_cast<size_t>(maps->width) * maps->height,
                      0.0f);
}

}  // namespace

void EstimateNormals(const PinholeCamera& camera, DenseMaps* maps) {
  ClearNormals(maps);
  for (int row = 0; row < maps->height; ++row) {
    EstimateRow(camera, row, maps);
  }
}

void EstimateNormals(const PinholeCamera& camera,
                     ThreadPool* pool,
                     Progress* progress,
                     DenseMaps* maps) {
  ClearNormals(maps);
  WatchedParallelFor(static_cast<size_t>(maps->height),
                     pool,
                     progress,
                     [&](const size_t row, int) {
                       EstimateRow(camera, static_cast<int>(row), maps);
                     });
}

}  // namespace structnerf
