#include "nerf/extract/confidence.h"

#include "nerf/extract/map_resolution.h"

#include <algorithm>
#include <cmath>

namespace structnerf {
namespace {

constexpr double kIntercept = -0.42;
constexpr double kByLogAngle = 0.73;
constexpr double kByLogSlope = -0.48;

// Beyond these, nothing more is learned.
constexpr double kMinAngle = 1.0;  // degrees; also of unconfirmed pixels
constexpr double kMaxAngle = 30.0;
constexpr double kMinSlope = 0.3;  // per radian
constexpr double kMaxSlope = 30.0;

// Of central differences between pixels so far away, where there are pixels on
// both sides.
double LargestSlope(const PinholeCamera& camera,
                    const DenseMaps& maps,
                    const int col,
                    const int row,
                    const int offset) {
  const auto depth = [&](const int other_col, const int other_row) {
    return static_cast<double>(
        maps.depth[static_cast<size_t>(
                       std::clamp(other_row, 0, maps.height - 1)) *
                       maps.width +
                   std::clamp(other_col, 0, maps.width - 1)]);
  };
  const double by_x =
      camera.fx * std::abs(depth(col + offset, row) - depth(col - offset, row));
  const double by_y =
      camera.fy * std::abs(depth(col, row + offset) - depth(col, row - offset));
  return 0.5 * std::max(by_x, by_y) / (offset * depth(col, row));
}

}  // namespace

std::vector<float> EstimateConfidence(const PinholeCamera& camera,
                                      const DenseMaps& maps,
                                      const std::vector<float>& angles) {
  const int offset = WholePixelsPerReferencePixel(camera);
  std::vector<float> confidence(maps.depth.size(), 0.0f);
  for (int row = 0; row < maps.height; ++row) {
    for (int col = 0; col < maps.width; ++col) {
      const size_t pixel = static_cast<size_t>(row) * maps.width + col;
      if (maps.depth[pixel] <= 0) {
        continue;
      }
      const double angle =
          std::clamp(static_cast<double>(angles[pixel]), kMinAngle, kMaxAngle);
      const double slope = std::clamp(
          LargestSlope(camera, maps, col, row, offset), kMinSlope, kMaxSlope);
      const double logit = kIntercept + kByLogAngle * std::log(angle) +
                           kByLogSlope * std::log(slope);
      confidence[pixel] = static_cast<float>(1 / (1 + std::exp(-logit)));
    }
  }
  return confidence;
}

}  // namespace structnerf
