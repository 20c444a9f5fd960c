#pragma once

#include "nerf/train/training_views.h"

#include <cstdint>
#include <vector>

namespace structnerf {

// Pixels of a view that stand out, as direct odometry picks them (Engel et al.
// 2018, "Direct Sparse Odometry", section 3.1) and the paper's ablation of
// dense sampling trains on: of each cell of 4 x 4 pixels the one with the
// largest gradient of grey values, if that is larger than the median of its
// block of 32 x 32 pixels by 7 of 255 grey levels. Pixels at the border and
// beside masked ones have no gradient. Returns row * width + col, ascending by
// cell.
std::vector<uint32_t> SelectKeypoints(const TrainingViews& views, int view_idx);

}  // namespace structnerf
