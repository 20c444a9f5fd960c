#pragma once

#include "nerf/scene.h"

#include <vector>

namespace structnerf {

// A sparse point seen in a view, as the sparse loss wants it.
struct DepthSample {
  int view_idx = -1;
  double x = 0;  // in the image coordinates of View::ImageCamera
  double y = 0;
  double depth = 0;  // z-depth, world units, > 0

  // Mean reprojection error e of the point, divided by that of all points; 1 if
  // no errors are known.
  float error_ratio = 1;

  // exp(-(e / mean e)^2) of the point's mean reprojection error e (paper, eq.
  // 13, which sums e over the track and so distrusts long ones). 1 if no
  // errors are known.
  float weight = 1;
};

// All observations of sparse points that lie in their image, outside masks and
// in front of the camera, grouped by view.
std::vector<std::vector<DepthSample>> CollectDepthSamples(const Scene& scene);

// Depth at a pixel interpolated from the samples of its view: inverse-distance
// weighted mean of the inverse depths of the 8 nearest. World units; 0 if there
// are no samples.
double InterpolateDepth(const std::vector<DepthSample>& samples,
                        double x,
                        double y);

}  // namespace structnerf
