#pragma once

#include "nerf/analysis/scene_decision.h"
#include "nerf/scene.h"

#include <string>
#include <vector>

namespace structnerf {

// How the exposures of photographs differ.
struct ExposureFit {
  // Of each view. The geometric mean of the gains is 1, the mean of the offsets
  // 0; views that show too few points have the mean exposure.
  std::vector<Exposure> exposures;

  // What the exposures make of mid grey, as a root mean square over views and
  // channels of the difference from it, in units of the full range.
  double variation = 0;

  // Median difference, in units of the full range, between the colours in which
  // photographs show a point and the colour it has, taken for equally exposed
  // and as the fit exposes them. What is left is noise, view-dependent colour
  // and wrong matches.
  double residual_before = 0;
  double residual = 0;

  // Whether the exposures differ by more than what compression and vignettes
  // do, so that it pays to account for them.
  bool IsSignificant() const;
};

// Fits Exposure, channel by channel, to the colours in which the photographs
// show the sparse points (CollectPointColors), by robust least squares. The
// same scene gives the same fit.
ExposureFit FitExposures(const Scene& scene);

// Gives the views the exposures of the fit if `exposure`
// (LossOptions::exposure) is "affine", or "auto" and they are significant.
SceneDecision ChooseExposures(const std::string& exposure, Scene* scene);

}  // namespace structnerf
