#pragma once

#include "nerf/scene.h"

#include <vector>

namespace structnerf {

// Source views for each view, best first, at most `num_sources`. A source is
// good if it shares many sparse points that are seen from it under a useful
// angle: the score sums, over shared points, a weight that rises with the
// triangulation angle up to 5 degrees and falls slowly beyond (as the matching
// cost of patches does). Views that share too few points are filled up with
// cameras close by that look the same way. File names play no role.
std::vector<std::vector<int>> SelectSourceViews(const Scene& scene,
                                                int num_sources);

}  // namespace structnerf
