#pragma once

#include "colmap_plugin/dense_workspace.h"
#include "nerf/scene.h"

#include <cstddef>
#include <vector>

#include <colmap/scene/reconstruction.h>

#include <opencv2/core.hpp>

namespace structnerf {

// How well a photograph that nothing was learned from is predicted by others
// and their depth maps: tells good depth from bad where there is no truth.
// Blank pixels say nothing and do not count.
struct PhotographPrediction {
  size_t num_textured = 0;  // pixels of the photograph
  size_t num_wrong = 0;  // of these: those unlike it, or not predicted at all

  double ShareWrong() const {
    return num_textured > 0 ? static_cast<double>(num_wrong) /
                                  static_cast<double>(num_textured)
                            : 0;
  }
};

// Predicts one view: pixels of other photographs go where their depth says that
// this view sees them. The nearest hide what is behind them; those of about
// that depth are averaged.
class PhotographPredictor {
 public:
  // Of the size of `view.camera`, or 640 pixels if that is larger.
  explicit PhotographPredictor(const View& view);

  // `photograph`: grey; both have the size of `view.camera`. Depth is in world
  // units, 0 = none.
  void Add(const View& view,
           const cv::Mat1f& depth,
           const cv::Mat1b& photograph);

  // In windows of 11x11 pixels: the structure term of structural similarity
  // (Wang et al. 2004), which exposure does not change, is below 0.5 where they
  // are unlike.
  PhotographPrediction Compare(const cv::Mat1b& photograph) const;

 private:
  struct MovedPixel {
    size_t place = 0;  // in this view
    float depth = 0;
    uint8_t grey = 0;
  };

  cv::Mat1f Predict(cv::Mat1f* is_covered) const;

  View view_;  // reduced
  std::vector<MovedPixel> pixels_;
};

// Over the views that a run with `test_every` has held out, from the
// photometric maps of the 12 best source views of each that were trained on.
// `model`: the undistorted one of the workspace. Throws std::runtime_error,
// naming the file, if an image or a map cannot be read.
PhotographPrediction PredictHeldOutPhotographs(
    const DenseWorkspace& workspace,
    const colmap::Reconstruction& model,
    int test_every);

}  // namespace structnerf
