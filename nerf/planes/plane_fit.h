#pragma once

#include "nerf/planes/plane_view.h"
#include "nerf/planes/segment_anchors.h"

namespace structnerf {

// Fits a plane, as drawn from few anchors of the segment, to all that lie on it
// and sets its support. What these leave open stays as it was drawn: those
// along one line leave it as level or upright as it is, those spread over an
// area tilt it as they need. False if too few lie on it, or they are not spread
// over much of the segment, or too many lie behind or in front of it
// (plane_hypotheses.h). The segment has anchors.
bool FitToAnchors(const PlaneView& view,
                  const Segment& segment,
                  PlaneHypothesis* plane);

}  // namespace structnerf
