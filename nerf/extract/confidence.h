#pragma once

#include "nerf/extract/depth_averaging.h"
#include "nerf/progress.h"
#include "nerf/scene.h"
#include "nerf/util/thread_pool.h"

#include <vector>

namespace structnerf {

// How wrong a depth may be, relative to the true one, to count as right.
constexpr double kConfidentError = 0.05;

// For every pixel of a view the probability, in [0, 1], that its depth is
// right within kConfidentError; 0 where there is no depth. Row-major.
//
// A logistic model of two things that tell right from wrong depths in any
// scene: the angle under which a view confirms the pixel (`angles` of
// nerf/extract/consistency.h), and how steeply depth changes around it, in
// relative change per radian, because depth is least certain at edges. Its
// coefficients were fitted to the maps of two real rooms; one of them depends
// on whether depth was matched (`is_matched`), because matches err
// independently, so that a view that confirms one says more. structnerf_eval
// says how well it predicts on any scene with ground truth. Poses that are
// wrong as a whole are beyond it.
//
// `depths`: as in DenseMaps, of the size of `camera`. Throws Aborted if told
// to.
std::vector<float> EstimateConfidence(const PinholeCamera& camera,
                                      const std::vector<float>& depths,
                                      const std::vector<float>& angles,
                                      bool is_matched,
                                      ThreadPool* pool,
                                      Progress* progress);

// The same for depth that was averaged over views: instead of the angle, the
// number of depths that a mean is of, and how far they are apart.
std::vector<float> EstimateConfidence(const PinholeCamera& camera,
                                      const std::vector<float>& depths,
                                      const DepthAgreement& agreement,
                                      ThreadPool* pool,
                                      Progress* progress);

}  // namespace structnerf
