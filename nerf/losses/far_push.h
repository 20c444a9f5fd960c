#pragma once

#include "nerf/train/training_views.h"

#include <cstdint>
#include <vector>

namespace structnerf {

// How blank each pixel of a view is, for the far term: 255 where the grey
// values around it are all the same, falling to 0 at a standard deviation of
// 0.06 (of [0, 1]). Row-major, at training resolution; masked pixels are 0.
std::vector<uint8_t> MeasureBlankness(const TrainingViews& views, int view_idx);

// Loss -blankness * log(depth) of a ray. A blank surface looks the same at any
// depth between what stands before it and behind it. Light that is absorbed
// early hides what comes later, so the field would put it at the near end; this
// pulls it away as gently as a patch that is only a little off pulls the other
// way. Little holds against it where all of a wall is blank and only two views
// see it. Writes the derivative by depth, which must be positive.
float EvaluateFarPush(uint8_t blankness, float depth, float* d_depth);

}  // namespace structnerf
