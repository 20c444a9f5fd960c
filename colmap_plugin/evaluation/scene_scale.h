#pragma once

#include <cstddef>
#include <vector>

#include <colmap/scene/reconstruction.h>

#include <opencv2/core.hpp>

namespace structnerf {

// Structure-from-motion has no unit.
struct SceneScale {
  double metres_per_unit = 0;  // 0 = not known
  double relative_spread = 0;  // 1.4826 times the median absolute deviation
  size_t num_observations = 0;
};

// The scale that does not depend on what is evaluated: the median, over the
// observations of sparse points, of true depth divided by the point's depth.
class SceneScaleEstimator {
 public:
  // `truth` covers the image, metres, 0 = no value.
  void AddImage(const colmap::Reconstruction& reconstruction,
                const colmap::Image& image,
                const cv::Mat1f& truth);

  SceneScale Estimate() const;

 private:
  std::vector<double> ratios_;
};

}  // namespace structnerf
