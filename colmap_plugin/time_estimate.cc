#include "colmap_plugin/time_estimate.h"

#include "colmap_plugin/option_table.h"
#include "nerf/view_mapper.h"

#include <algorithm>
#include <cmath>

#include <colmap/util/threading.h>

namespace structnerf {
namespace {

// CPU seconds per unit of work that all threads share ...
constexpr double kPerSample = 0.55e-6;         // of a training ray
constexpr double kPerTrainingPixel = 0.8e-6;   // loading, superpixels
constexpr double kPerRenderedPixel = 0.55e-6;  // of the maps
constexpr double kPerMatchedPixel = 2.4e-6;    // one sweep of matching
constexpr double kPerCompletedPixel = 0.75e-6;
constexpr double kPerFusedPixel = 0.8e-6;      // and written
constexpr double kPerAveragedPixel = 0.03e-6;  // over one view
constexpr double kDensityCache = 2.0;

// ... and that one thread does.
constexpr double kPerCheckedPixel = 0.4e-6;

// A quality, with another number of sweeps than its own if that is not kItsOwn.
struct Candidate {
  const char* quality;
  int num_sweeps;
};
constexpr int kItsOwn = -1;

// From the best to the fastest.
std::vector<Candidate> MakeCandidates(
    const std::vector<PinholeCamera>& cameras) {
  std::vector<Candidate> candidates = {{"high", kItsOwn},
                                       {"medium", kItsOwn},
                                       {"medium", 1},
                                       {"low", kItsOwn},
                                       {"low", 0}};
  const int high_size = QualityPreset("high").training.max_image_size;
  const auto is_large = [&](const PinholeCamera& camera) {
    return std::max(camera.width, camera.height) > high_size;
  };
  if (std::any_of(cameras.begin(), cameras.end(), is_large)) {
    // Else it is the same as high.
    candidates.insert(candidates.begin(), {"extreme", kItsOwn});
  }
  return candidates;
}

}  // namespace

TimeEstimate EstimateTime(const StructNerfOptions& options,
                          const std::vector<PinholeCamera>& cameras) {
  const ReconstructionOptions& method = options.reconstruction;
  double map_pixels = 0;
  double training_pixels = 0;
  for (const PinholeCamera& camera : cameras) {
    map_pixels += camera.NumPixels();
    training_pixels +=
        camera.Reduced(method.training.max_image_size).NumPixels();
  }
  const double samples = static_cast<double>(method.training.num_steps) *
                         method.training.rays_per_step *
                         method.sampling.num_samples;
  const int num_sweeps =
      method.stereo.num_iterations > 0 ? method.stereo.num_iterations + 1 : 0;
  const double completed_pixels =
      method.CompletesPlanes() ? training_pixels : 0;
  const size_t num_averaged = method.NumAveragedViews(cameras.size());
  const double num_threads =
      colmap::GetEffectiveNumThreads(method.training.num_threads);
  TimeEstimate estimate;
  estimate.loading = kPerTrainingPixel * training_pixels / num_threads;
  estimate.training = (kPerSample * samples + kDensityCache) / num_threads;
  if (method.LearnsFromMatches()) {
    estimate.matching =
        ((kPerRenderedPixel +
          kPerMatchedPixel * (NumBriefSweeps(method.stereo) + 1)) *
             training_pixels +
         kPerCompletedPixel * completed_pixels) /
            num_threads +
        kPerCheckedPixel * training_pixels;
  }
  estimate.rendering = (kPerRenderedPixel * map_pixels +
                        kPerMatchedPixel * num_sweeps * training_pixels) /
                       num_threads;
  estimate.finishing =
      (kPerCompletedPixel * completed_pixels +
       (kPerFusedPixel + kPerAveragedPixel * num_averaged) * map_pixels) /
          num_threads +
      kPerCheckedPixel * map_pixels;
  return estimate;
}

QualityChoice QualityForTime(const StructNerfOptions& options,
                             const std::vector<PinholeCamera>& cameras,
                             const double slowness) {
  const bool has_matching = MakePreset(options.method, "high").MatchesViews();
  StructNerfOptions planned = options;
  StereoOptions& stereo = planned.reconstruction.stereo;
  for (const Candidate& candidate : MakeCandidates(cameras)) {
    planned.reconstruction = MakePreset(options.method, candidate.quality);
    planned.reconstruction.training.num_threads =
        options.reconstruction.training.num_threads;
    if (has_matching && candidate.num_sweeps != kItsOwn) {
      stereo.num_iterations = candidate.num_sweeps;
    }
    const TimeEstimate estimate = EstimateTime(planned, cameras);
    const double min_steps = planned.reconstruction.LearnsFromMatches()
                                 ? 2 * kMinTrainingSteps
                                 : kMinTrainingSteps;
    const double min_share =
        std::clamp(min_steps / planned.reconstruction.training.num_steps,
                   kMinTrainingShare,
                   1.0);
    const double needed =
        estimate.Total() - (1 - min_share) * estimate.training;
    if (slowness * needed <= 60 * options.max_minutes) {
      return {candidate.quality, stereo.num_iterations};
    }
  }
  return {"low", stereo.num_iterations};
}

}  // namespace structnerf
