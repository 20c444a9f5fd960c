#pragma once

#include "colmap_plugin/evaluation/depth_evaluation.h"
#include "colmap_plugin/evaluation/truth_views.h"

#include <string>

#include <opencv2/core.hpp>

namespace structnerf {

// |B - A| / A at the pixels of A's map of an image; -1 where one of the two has
// no depth.
//   a_per_b: units of A per unit of B.
cv::Mat1f RelativeDifferences(const PredictedDepth& a,
                              const PredictedDepth& b,
                              double a_per_b);

// |prediction - truth| in metres at the pixels of an image's truth; -1 where
// one of the two has no depth.
//   true_depth: truth->Depth(name).
cv::Mat1f AbsoluteErrors(const PredictedDepth& prediction,
                         double metres_per_unit,
                         const cv::Mat1f& true_depth,
                         const std::string& name,
                         TruthViews* truth);

}  // namespace structnerf
