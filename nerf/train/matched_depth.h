#pragma once

#include "nerf/progress.h"

#include <functional>
#include <memory>
#include <vector>

namespace structnerf {

// Depth that matching gave to views in the midst of a training and other views
// confirm, of each view and pixel of its training image, row by row: z-depth in
// field units, 0 = none. Empty for views that are not trained on.
using MatchedDepth = std::vector<std::vector<float>>;

// Matches views from what has been learned so far. Null if it was asked to stop
// meanwhile; throws Aborted if told to.
using MatchFunction =
    std::function<std::shared_ptr<const MatchedDepth>(Progress*)>;

// Share of all pixels that have a depth.
double ConfirmedShare(const MatchedDepth& depth);

}  // namespace structnerf
