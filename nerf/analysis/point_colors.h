#pragma once

#include "nerf/scene.h"

#include <cstddef>
#include <vector>

#include <Eigen/Core>

namespace structnerf {

// The colour, channels in [0, 1], in which a photograph shows a sparse point.
struct PointColor {
  size_t view_idx = 0;
  size_t point_idx = 0;
  Eigen::Vector3f color;
};

// Of points that at least two photographs show, point by point, evenly chosen
// if there are too many to fit something to. Pixels that are masked, black or
// saturated do not count.
std::vector<PointColor> CollectPointColors(const Scene& scene);

// How colours depend on where they are seen from: the median difference, over
// channels, between the colour in which a photograph, with its exposure undone,
// shows a sparse point, and the mean of that point's colours. In units of the
// full range; 0 without colours.
double MeasureColorSpread(const Scene& scene);

}  // namespace structnerf
