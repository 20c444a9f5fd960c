#pragma once

#include "nerf/losses/view_warp.h"
#include "nerf/planes/plane_view.h"
#include "nerf/train/training_views.h"

#include <vector>

namespace structnerf {

// Planes that a superpixel without texture of its own may lie on. What is known
// of such a segment is what is reliable at its border, but the border often
// belongs to something in front. So a plane counts as possible if
// - it is level or upright with respect to the dominant direction, for a border
//   along one line alone would leave it free to turn about that line;
// - some reliable pixels lie on it, spread over a good part of the segment;
// - hardly any inside the segment lie behind it (in front of it they may
//   belong to an occluder), and few in front of it far from the border;
// - other views show much the same colours there.
// Which of them is right is left to the other views (plane_completion.h).
//
// `border`: how far, in pixels, a match may be off at an edge; half the side of
// the matching window, at least 2. `direction`: dominant direction in the
// camera frame. `warps`: to each of the `sources`, to compare colours. Returns
// the best few planes of each of the view's segments, by label.
std::vector<std::vector<PlaneHypothesis>> FindPlaneHypotheses(
    const PlaneView& view,
    int border,
    const Eigen::Vector3f& direction,
    int view_idx,
    const std::vector<ViewWarp>& warps,
    const std::vector<int>& sources,
    const TrainingViews& views);

}  // namespace structnerf
