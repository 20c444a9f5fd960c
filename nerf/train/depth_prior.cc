#include "nerf/train/depth_prior.h"

#include "nerf/scene_frame.h"

#include <algorithm>
#include <cmath>

namespace structnerf {
namespace {

constexpr size_t kNumNeighbors = 8;

// Mean of the known reprojection errors; 0 if none is known.
double MeanError(const Scene& scene) {
  double sum = 0;
  size_t count = 0;
  for (const SparsePoint& point : scene.points) {
    if (point.error >= 0) {
      sum += point.error;
      ++count;
    }
  }
  return count > 0 ? sum / count : 0.0;
}

}  // namespace

std::vector<std::vector<DepthSample>> CollectDepthSamples(const Scene& scene) {
  std::vector<std::vector<DepthSample>> samples(scene.views.size());
  const double mean_error = MeanError(scene);
  for (const SparsePoint& point : scene.points) {
    const bool is_known = mean_error > 0 && point.error >= 0;
    const double ratio = is_known ? point.error / mean_error : 0.0;
    for (const Observation& observation : point.track) {
      const View& view = scene.views[observation.view_idx];
      const PinholeCamera camera = view.ImageCamera();
      DepthSample sample;
      sample.view_idx = observation.view_idx;
      sample.x = observation.xy.x() * camera.width / view.camera.width;
      sample.y = observation.xy.y() * camera.height / view.camera.height;
      sample.depth = DepthInView(view, point.xyz);
      sample.error_ratio = is_known ? static_cast<float>(ratio) : 1.0f;
      sample.weight = static_cast<float>(std::exp(-ratio * ratio));
      if (!(sample.depth > 0) || sample.x < 0 || sample.y < 0 ||
          sample.x >= camera.width || sample.y >= camera.height) {
        continue;
      }
      const size_t pixel = static_cast<size_t>(sample.y) * camera.width +
                           static_cast<size_t>(sample.x);
      if (view.mask.empty() || view.mask[pixel] != 0) {
        samples[observation.view_idx].push_back(sample);
      }
    }
  }
  return samples;
}

double InterpolateDepth(const std::vector<DepthSample>& samples,
                        const double x,
                        const double y) {
  // (squared distance, inverse depth) of the nearest samples, a max-heap.
  std::pair<double, double> nearest[kNumNeighbors];
  size_t count = 0;
  for (const DepthSample& sample : samples) {
    const double dx = sample.x - x;
    const double dy = sample.y - y;
    const std::pair<double, double> candidate(dx * dx + dy * dy,
                                              1.0 / sample.depth);
    if (count < kNumNeighbors) {
      nearest[count++] = candidate;
      std::push_heap(nearest, nearest + count);
    } else if (candidate.first < nearest[0].first) {
      std::pop_heap(nearest, nearest + count);
      nearest[count - 1] = candidate;
      std::push_heap(nearest, nearest + count);
    }
  }
  double sum = 0;
  double sum_weights = 0;
  for (size_t i = 0; i < count; ++i) {
    // One square pixel keeps the weight of a sample at the pixel finite.
    const double weight = 1.0 / (nearest[i].first + 1.0);
    sum += weight * nearest[i].second;
    sum_weights += weight;
  }
  return sum > 0 ? sum_weights / sum : 0.0;
}

}  // namespace structnerf
