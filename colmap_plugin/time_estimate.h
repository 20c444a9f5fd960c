#pragma once

#include "colmap_plugin/structnerf_options.h"
#include "nerf/scene.h"

#include <string>
#include <vector>

namespace structnerf {

// Wall time in seconds of the parts of a run.
struct TimeEstimate {
  double loading = 0;    // undistortion, decoding, superpixels
  double training = 0;   // all steps
  double matching = 0;   // between two rounds of training
  double rendering = 0;  // of all views, with matching
  double finishing = 0;  // planes, consistency, fusion, writing

  double Total() const {
    return loading + training + matching + rendering + finishing;
  }
};

// The least share of its training that a quality is worth running with, and
// the least number of steps of each round: fewer do not bring a field to rest,
// whatever comes after them.
constexpr double kMinTrainingShare = 0.25;
constexpr double kMinTrainingSteps = 400;

// What a run will roughly take on this machine with nothing else to do: the
// work that the options ask for, at rates that were measured on a server's core
// of 2023. `cameras`: of the undistorted images.
TimeEstimate EstimateTime(const StructNerfOptions& options,
                          const std::vector<PinholeCamera>& cameras);

// A quality word, and the sweeps of matching to run it with
// (StereoOptions::num_iterations): its own, or fewer.
struct QualityChoice {
  std::string quality;
  int num_sweeps = 0;
};

// The best whose run fits into `options.max_minutes` with at least
// kMinTrainingShare of its training and kMinTrainingSteps; "low" without
// matching if none does.
// `slowness`: MeasureSlowness().
QualityChoice QualityForTime(const StructNerfOptions& options,
                             const std::vector<PinholeCamera>& cameras,
                             double slowness);

}  // namespace structnerf
