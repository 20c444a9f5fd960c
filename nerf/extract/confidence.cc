#include "nerf/extract/confidence.h"

#include "nerf/extract/map_resolution.h"
#include "nerf/watched_loop.h"

#include <algorithm>
#include <cmath>

namespace structnerf {
namespace {

constexpr double kIntercept = -0.42;
constexpr double kInterceptOfMatches = 0.18;
constexpr double kByLogAngle = 0.73;
constexpr double kByLogSlope = -0.48;

// Beyond these, nothing more is learned.
constexpr double kMinAngle = 1.0;  // degrees; also of unconfirmed pixels
constexpr double kMaxAngle = 30.0;
constexpr double kMinSlope = 0.3;  // per radian
constexpr double kMaxSlope = 30.0;

// Of differences between pixels so far away on either side, or on one side
// where only that one has a depth. A pixel on its own is as uncertain as any.
double LargestSlope(const PinholeCamera& camera,
                    const DenseMaps& maps,
                    const int col,
                    const int row,
                    const int offset) {
  // 0 = none.
  const auto depth = [&](const int other_col, const int other_row) {
    const bool is_inside = other_col >= 0 && other_col < maps.width &&
                           other_row >= 0 && other_row < maps.height;
    return is_inside
               ? static_cast<double>(
                     maps.depth[static_cast<size_t>(other_row) * maps.width +
                                other_col])
               : 0.0;
  };
  const double center = depth(col, row);
  double largest = -1;
  const auto compare =
      [&](const double before, const double after, const double focal_length) {
        const int num_steps = (before > 0) + (after > 0);
        if (num_steps > 0) {
          const double change =
              (after > 0 ? after : center) - (before > 0 ? before : center);
          largest = std::max(
              largest,
              focal_length * std::abs(change) / (num_steps * offset * center));
        }
      };
  compare(depth(col - offset, row), depth(col + offset, row), camera.fx);
  compare(depth(col, row - offset), depth(col, row + offset), camera.fy);
  return largest < 0 ? kMaxSlope : largest;
}

}  // namespace

std::vector<float> EstimateConfidence(const PinholeCamera& camera,
                                      const DenseMaps& maps,
                                      const std::vector<float>& angles,
                                      const bool is_matched,
                                      ThreadPool* pool,
                                      Progress* progress) {
  const double intercept = is_matched ? kInterceptOfMatches : kIntercept;
  const int offset = WholePixelsPerReferencePixel(camera);
  std::vector<float> confidence(maps.depth.size(), 0.0f);
  const auto estimate_row = [&](const size_t item, int) {
    const int row = static_cast<int>(item);
    for (int col = 0; col < maps.width; ++col) {
      const size_t pixel = static_cast<size_t>(row) * maps.width + col;
      if (maps.depth[pixel] <= 0) {
        continue;
      }
      const double angle =
          std::clamp(static_cast<double>(angles[pixel]), kMinAngle, kMaxAngle);
      const double slope = std::clamp(
          LargestSlope(camera, maps, col, row, offset), kMinSlope, kMaxSlope);
      const double logit = intercept + kByLogAngle * std::log(angle) +
                           kByLogSlope * std::log(slope);
      confidence[pixel] = static_cast<float>(1 / (1 + std::exp(-logit)));
    }
  };
  WatchedParallelFor(
      static_cast<size_t>(maps.height), pool, progress, estimate_row);
  return confidence;
}

}  // namespace structnerf
