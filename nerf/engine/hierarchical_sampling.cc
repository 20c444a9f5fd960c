#include "nerf/engine/hierarchical_sampling.h"

#include "nerf/engine/ray_tile.h"

#include <algorithm>

namespace structnerf {
namespace {

// Every interval counts at least this much (as in NeRF's code), so that rays
// that stop no light are sampled evenly.
constexpr float kMinWeight = 1e-5f;

// Of a batch, unless one tile has more.
constexpr size_t kMaxBatchPoints = size_t{1} << 14;

}  // namespace

RayPoints StratifiedPoints(const float near,
                           const float far,
                           const int count,
                           Random* random) {
  RayPoints points;
  const float length = (far - near) / static_cast<float>(count);
  for (int i = 0; i < count; ++i) {
    const float begin = near + length * static_cast<float>(i);
    points.edges.push_back(begin);
    points.depth.push_back(begin +
                           length * (random ? random->NextFloat() : 0.5f));
  }
  points.edges.push_back(far);
  return points;
}

RayPoints RefinedPoints(const RayPoints& coarse,
                        const float* weight,
                        const int count,
                        const float guide_depth,
                        const float guide_deviation,
                        Random* random) {
  const int num_guided = random && guide_depth > 0 ? count / 2 : 0;
  const int num_drawn = count - num_guided;
  const int num_intervals = static_cast<int>(coarse.depth.size());
  float sum = 0;
  for (int i = 0; i < num_intervals; ++i) {
    sum += weight[i] + kMinWeight;
  }
  RayPoints points;
  points.depth = coarse.depth;
  int interval = 0;
  float begin = 0;  // share in front of the interval
  float share = (weight[0] + kMinWeight) / sum;
  for (int i = 0; i < num_drawn; ++i) {
    const float target =
        (static_cast<float>(i) + (random ? random->NextFloat() : 0.5f)) /
        static_cast<float>(num_drawn);
    while (target > begin + share && interval + 1 < num_intervals) {
      begin += share;
      ++interval;
      share = (weight[interval] + kMinWeight) / sum;
    }
    const float where = std::min((target - begin) / share, 1.0f);
    points.depth.push_back(
        coarse.edges[interval] +
        where * (coarse.edges[interval + 1] - coarse.edges[interval]));
  }
  for (int i = 0; i < num_guided; ++i) {
    const float z = guide_depth + guide_deviation * random->NextNormal();
    points.depth.push_back(
        std::min(std::max(z, coarse.edges.front()), coarse.edges.back()));
  }
  std::sort(points.depth.begin(), points.depth.end());
  points.edges.push_back(coarse.edges.front());
  for (size_t i = 0; i + 1 < points.depth.size(); ++i) {
    points.edges.push_back(0.5f * (points.depth[i] + points.depth[i + 1]));
  }
  points.edges.push_back(coarse.edges.back());
  return points;
}

MlpBatchSize::MlpBatchSize(const SamplingOptions& sampling) {
  // The fine network sees the coarse one's points again.
  const size_t points_per_tile =
      static_cast<size_t>(kMaxTileRays) *
      (2 * sampling.num_samples + sampling.num_fine_samples);
  num_tiles = std::max<size_t>(1, kMaxBatchPoints / points_per_tile);
  num_points = num_tiles * points_per_tile;
}

}  // namespace structnerf
