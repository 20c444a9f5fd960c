#pragma once

#include "nerf/options.h"
#include "nerf/scene.h"

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace structnerf {

// Angle in radians, in [0, pi], between the rays from two cameras to a point.
double TriangulationAngle(const Eigen::Vector3d& center1,
                          const Eigen::Vector3d& center2,
                          const Eigen::Vector3d& xyz);

// Source views for each view, best first, at most `num_sources`, out of
// `candidates` (ascending; empty = all views). A source is
// good if it shares many sparse points that are seen from it under a useful
// angle: the score sums, over shared points, a weight that rises with the
// triangulation angle up to 5 degrees and falls slowly beyond (as the matching
// cost of patches does). Views that share too few points are filled up with
// cameras close by that look the same way. File names play no role.
std::vector<std::vector<int>> SelectSourceViews(
    const Scene& scene,
    int num_sources,
    const std::vector<int>& candidates = {});

// Sources of the patch loss: `sources` (as selected above) or, if
// `options.source_selection` says so, the neighbours in the order of the views,
// as the paper has it for frames of a video: options.num_sources / 2 before and
// as many after each view, nearest first, where there are so many.
//   train_view_idxs: ascending.
std::vector<std::vector<int>> SelectTrainingSources(
    const std::vector<std::vector<int>>& sources,
    const LossOptions& options,
    const std::vector<int>& train_view_idxs);

// Whether a view is kept out of training to be tested on: of every `test_every`
// views the last, as in the paper; 0 = none.
bool IsHeldOut(size_t view_idx, int test_every);

// All of these, and all others, ascending.
std::vector<int> HeldOutViewIdxs(size_t num_views, int test_every);
std::vector<int> TrainedViewIdxs(size_t num_views, int test_every);

// The photographs whose latent codes a view is rendered with, see
// RayTile::appearance.
using Appearance = std::array<int, 2>;
constexpr Appearance kNoAppearance = {-1, -1};

// For every view: itself if it is trained on, else what
// TrainingOptions::latent_test says: "zero" codes, or the "neighbors" before
// and after it that are trained on, at either end the nearest one alone.
//   test_view_idxs: those that are not trained on, at least one view is.
std::vector<Appearance> SelectAppearances(
    size_t num_views,
    const std::vector<int>& test_view_idxs,
    const std::string& latent_test);

}  // namespace structnerf
