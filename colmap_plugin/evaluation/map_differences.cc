#include "colmap_plugin/evaluation/map_differences.h"

#include "colmap_plugin/evaluation/pixel_lookup.h"

#include <cmath>

namespace structnerf {

cv::Mat1f RelativeDifferences(const PredictedDepth& a,
                              const PredictedDepth& b,
                              const double a_per_b) {
  // Pixels of two dense maps correspond centre to centre: whatever point of a
  // pixel its value belongs to, it is the same in both.
  const cv::Mat1f b_at_a = LookUp(
      GridRays(a.camera, a.depth.size(), kPixelCenter), b.camera, b.depth);
  cv::Mat1f differences(a.depth.size(), -1.0f);
  for (int row = 0; row < a.depth.rows; ++row) {
    for (int col = 0; col < a.depth.cols; ++col) {
      const float depth_a = a.depth(row, col);
      const float depth_b = b_at_a(row, col);
      if (depth_a > 0 && std::isfinite(depth_a) && depth_b > 0) {
        differences(row, col) =
            static_cast<float>(std::abs(a_per_b * depth_b / depth_a - 1));
      }
    }
  }
  return differences;
}

cv::Mat1f AbsoluteErrors(const PredictedDepth& prediction,
                         const double metres_per_unit,
                         const cv::Mat1f& true_depth,
                         const std::string& name,
                         TruthViews* truth) {
  const cv::Mat1f predicted = LookUp(truth->Rays(name, true_depth.size()),
                                     prediction.camera,
                                     prediction.depth);
  cv::Mat1f errors(true_depth.size(), -1.0f);
  for (int row = 0; row < true_depth.rows; ++row) {
    for (int col = 0; col < true_depth.cols; ++col) {
      if (true_depth(row, col) > 0 && predicted(row, col) > 0) {
        errors(row, col) = static_cast<float>(std::abs(
            metres_per_unit * predicted(row, col) - true_depth(row, col)));
      }
    }
  }
  return errors;
}

}  // namespace structnerf
