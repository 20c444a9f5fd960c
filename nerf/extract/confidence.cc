#include "nerf/extract/confidence.h"

#include "nerf/extract/map_resolution.h"
#include "nerf/watched_loop.h"

#include <algorithm>
#include <cmath>

namespace structnerf {
namespace {

// Of a depth that was not averaged.
constexpr double kIntercept = -0.42;
constexpr double kInterceptOfMatches = 0.18;
constexpr double kByLogAngle = 0.73;

// Of a mean.
constexpr double kInterceptOfMeans = -0.04;
constexpr double kByLogNum = 1.28;  // of one more than there are depths
constexpr double kBySpread = -86;

constexpr double kByLogSlope = -0.48;  // of both

// Beyond these, nothing more is learned.
constexpr double kMinAngle = 1.0;  // degrees; also of unconfirmed pixels
constexpr double kMaxAngle = 30.0;
constexpr double kMinSlope = 0.3;  // per radian
constexpr double kMaxSlope = 30.0;

// Of differences between pixels so far away on either side, or on one side
// where only that one has a depth. A pixel on its own is as uncertain as any.
double LargestSlope(const PinholeCamera& camera,
                    const std::vector<float>& depths,
                    const int col,
                    const int row,
                    const int offset) {
  // 0 = none.
  const auto depth = [&](const int other_col, const int other_row) {
    const bool is_inside = other_col >= 0 && other_col < camera.width &&
                           other_row >= 0 && other_row < camera.height;
    return is_inside
               ? static_cast<double>(
                     depths[static_cast<size_t>(other_row) * camera.width +
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

double ClampedLog(const double value, const double min, const double max) {
  return std::log(std::clamp(value, min, max));
}

// The probabilities of all pixels that have a depth. `logit(pixel)`: what of
// their logit is not due to the slope.
template <typename Logit>
std::vector<float> EstimatePixels(const PinholeCamera& camera,
                                  const std::vector<float>& depths,
                                  ThreadPool* pool,
                                  Progress* progress,
                                  const Logit& logit) {
  const int offset = WholePixelsPerReferencePixel(camera);
  std::vector<float> confidence(depths.size(), 0.0f);
  const auto estimate_row = [&](const size_t item, int) {
    const int row = static_cast<int>(item);
    for (int col = 0; col < camera.width; ++col) {
      const size_t pixel = item * camera.width + col;
      if (depths[pixel] > 0) {
        const double slope = LargestSlope(camera, depths, col, row, offset);
        const double whole_logit =
            logit(pixel) +
            kByLogSlope * ClampedLog(slope, kMinSlope, kMaxSlope);
        confidence[pixel] =
            static_cast<float>(1 / (1 + std::exp(-whole_logit)));
      }
    }
  };
  WatchedParallelFor(
      static_cast<size_t>(camera.height), pool, progress, estimate_row);
  return confidence;
}

}  // namespace

std::vector<float> EstimateConfidence(const PinholeCamera& camera,
                                      const std::vector<float>& depths,
                                      const std::vector<float>& angles,
                                      const bool is_matched,
                                      ThreadPool* pool,
                                      Progress* progress) {
  const double intercept = is_matched ? kInterceptOfMatches : kIntercept;
  return EstimatePixels(
      camera, depths, pool, progress, [&](const size_t pixel) {
        return intercept +
               kByLogAngle * ClampedLog(angles[pixel], kMinAngle, kMaxAngle);
      });
}

std::vector<float> EstimateConfidence(const PinholeCamera& camera,
                                      const std::vector<float>& depths,
                                      const DepthAgreement& agreement,
                                      ThreadPool* pool,
                                      Progress* progress) {
  return EstimatePixels(
      camera, depths, pool, progress, [&](const size_t pixel) {
        return kInterceptOfMeans +
               kByLogNum * std::log1p(agreement.num_depths[pixel]) +
               kBySpread * agreement.spread[pixel];
      });
}

}  // namespace structnerf
