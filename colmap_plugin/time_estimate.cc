#include "colmap_plugin/time_estimate.h"

#include <algorithm>
#include <cmath>
#include <thread>

namespace structnerf {
namespace {

// CPU seconds per unit of work.
constexpr double kPerSample = 1.1e-6;         // of a training ray
constexpr double kPerTrainingPixel = 2.0e-6;  // loading, superpixels
constexpr double kPerMatchedPixel = 1.5e-6;   // one sweep of matching
constexpr double kPerMapPixel = 1.3e-6;       // rendering, writing, fusing
constexpr double kFixed = 2.0;                // density cache, start

}  // namespace

double EstimateSeconds(const StructNerfOptions& options,
                       const std::vector<PinholeCamera>& cameras) {
  const ReconstructionOptions& method = options.reconstruction;
  double map_pixels = 0;
  double training_pixels = 0;
  for (const PinholeCamera& camera : cameras) {
    const double pixels = static_cast<double>(camera.width) * camera.height;
    const double ratio =
        std::min(1.0,
                 static_cast<double>(method.training.max_image_size) /
                     std::max(camera.width, camera.height));
    map_pixels += pixels;
    training_pixels += ratio * ratio * pixels;
  }
  const double samples = static_cast<double>(method.training.num_steps) *
                         method.training.rays_per_step *
                         method.sampling.num_samples;
  const int num_sweeps =
      method.stereo.num_iterations > 0 ? method.stereo.num_iterations + 1 : 0;
  const double cpu_seconds = kFixed + kPerSample * samples +
                             kPerTrainingPixel * training_pixels +
                             kPerMapPixel * map_pixels +
                             kPerMatchedPixel * num_sweeps * training_pixels;
  const int num_threads =
      method.training.num_threads > 0
          ? method.training.num_threads
          : static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  return cpu_seconds / num_threads;
}

}  // namespace structnerf
