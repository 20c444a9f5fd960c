#include "colmap_plugin/evaluation/photograph_prediction.h"

#include "colmap_plugin/evaluation/workspace_maps.h"
#include "colmap_plugin/image_file.h"
#include "colmap_plugin/scene_converter.h"
#include "nerf/view_selection.h"

#include <algorithm>
#include <limits>
#include <stdexcept>

#include <opencv2/imgproc.hpp>

namespace structnerf {
namespace {

constexpr int kMaxImageSize = 640;
constexpr int kNumSources = 12;

// Pixels that are farther than the nearest by this factor are hidden.
constexpr float kHiddenFrom = 1.03f;

// Windows, in pixels and squared grey levels.
constexpr int kWindowSize = 11;
constexpr float kMinVariance = 60;
constexpr float kStabilizer = 10;
constexpr float kMinSimilarity = 0.5f;

cv::Mat1f WindowMean(const cv::Mat1f& values) {
  cv::Mat1f mean;
  cv::boxFilter(values, mean, -1, {kWindowSize, kWindowSize});
  return mean;
}

// Of the pixels that `weight` is one at.
cv::Mat1f WeightedMean(const cv::Mat1f& values,
                       const cv::Mat1f& weight,
                       const cv::Mat1f& mean_weight) {
  return WindowMean(values.mul(weight)) / mean_weight;
}

template <typename Matrix>
Matrix Resized(const Matrix& image,
               const PinholeCamera& camera,
               const int interpolation) {
  Matrix resized;
  cv::resize(
      image, resized, {camera.width, camera.height}, 0, 0, interpolation);
  return resized;
}

}  // namespace

PhotographPredictor::PhotographPredictor(const View& view)
    : view_(PoseOf(view)) {
  view_.camera = view.camera.Reduced(kMaxImageSize);
}

void PhotographPredictor::Add(const View& view,
                              const cv::Mat1f& depth,
                              const cv::Mat1b& photograph) {
  const PinholeCamera& target = view_.camera;
  const PinholeCamera source = view.camera.Reduced(kMaxImageSize);
  const auto depths = Resized(depth, source, cv::INTER_NEAREST);
  const auto greys = Resized(photograph, source, cv::INTER_AREA);
  for (int row = 0; row < source.height; ++row) {
    for (int col = 0; col < source.width; ++col) {
      const double z = depths(row, col);
      if (!(z > 0)) {
        continue;
      }
      const Eigen::Vector3d in_source((col + 0.5 - source.cx) / source.fx * z,
                                      (row + 0.5 - source.cy) / source.fy * z,
                                      z);
      const Eigen::Vector3d in_view =
          view_.CamFromWorld(view.WorldFromCam(in_source));
      if (!(in_view.z() > 0)) {
        continue;
      }
      const double x = target.fx * in_view.x() / in_view.z() + target.cx;
      const double y = target.fy * in_view.y() / in_view.z() + target.cy;
      if (x >= 0 && y >= 0 && x < target.width && y < target.height) {
        pixels_.push_back(
            {static_cast<size_t>(y) * target.width + static_cast<size_t>(x),
             static_cast<float>(in_view.z()),
             greys(row, col)});
      }
    }
  }
}

cv::Mat1f PhotographPredictor::Predict(cv::Mat1f* is_covered) const {
  const size_t num_pixels = view_.camera.NumPixels();
  std::vector<float> nearest(num_pixels, std::numeric_limits<float>::max());
  for (const MovedPixel& pixel : pixels_) {
    nearest[pixel.place] = std::min(nearest[pixel.place], pixel.depth);
  }
  cv::Mat1f sum(view_.camera.height, view_.camera.width, 0.0f);
  cv::Mat1f count(sum.size(), 0.0f);
  for (const MovedPixel& pixel : pixels_) {
    if (pixel.depth <= kHiddenFrom * nearest[pixel.place]) {
      sum(static_cast<int>(pixel.place)) += pixel.grey;
      ++count(static_cast<int>(pixel.place));
    }
  }
  *is_covered = cv::min(count, 1.0f);
  return sum / cv::max(count, 1.0f);
}

PhotographPrediction PhotographPredictor::Compare(
    const cv::Mat1b& photograph) const {
  cv::Mat1f truth;
  Resized(photograph, view_.camera, cv::INTER_AREA).convertTo(truth, CV_32F);
  const cv::Mat1f truth_mean = WindowMean(truth);
  const cv::Mat1f texture =
      WindowMean(truth.mul(truth)) - truth_mean.mul(truth_mean);

  cv::Mat1f covered;
  const cv::Mat1f predicted = Predict(&covered);
  const cv::Mat1f mean_covered = cv::max(WindowMean(covered), 1e-6f);
  const auto mean = [&](const cv::Mat1f& values) {
    return WeightedMean(values, covered, mean_covered);
  };
  const cv::Mat1f mean_t = mean(truth);
  const cv::Mat1f mean_p = mean(predicted);
  const cv::Mat1f variance_t = mean(truth.mul(truth)) - mean_t.mul(mean_t);
  const cv::Mat1f variance_p =
      mean(predicted.mul(predicted)) - mean_p.mul(mean_p);
  const cv::Mat1f covariance = mean(truth.mul(predicted)) - mean_t.mul(mean_p);
  const cv::Mat1f similarity =
      (2 * covariance + kStabilizer) / (variance_t + variance_p + kStabilizer);

  const cv::Mat1b is_textured = texture > kMinVariance;
  const cv::Mat1b is_right = (covered > 0) & (similarity >= kMinSimilarity);
  PhotographPrediction prediction;
  prediction.num_textured = cv::countNonZero(is_textured);
  prediction.num_wrong = cv::countNonZero(is_textured & ~is_right);
  return prediction;
}

PhotographPrediction PredictHeldOutPhotographs(
    const DenseWorkspace& workspace,
    const colmap::Reconstruction& model,
    const int test_every) {
  const Scene scene = ConvertGeometry(model);
  const std::vector<std::vector<int>> sources = SelectSourceViews(
      scene, kNumSources, TrainedViewIdxs(scene.views.size(), test_every));
  const WorkspaceMaps maps(workspace, model, MapType::kPhotometric);
  const auto read_photograph = [&](const View& view) {
    const std::string path = workspace.ImagePath(view.name);
    cv::Mat1b photograph = ReadGreyImage(path);
    if (photograph.cols != view.camera.width ||
        photograph.rows != view.camera.height) {
      throw std::runtime_error("The image " + path +
                               " cannot be read, or is not of the size of its "
                               "camera.");
    }
    return photograph;
  };

  PhotographPrediction sum;
  for (const int view_idx : HeldOutViewIdxs(scene.views.size(), test_every)) {
    const View& view = scene.views[view_idx];
    PhotographPredictor predictor(view);
    for (const int source_idx : sources[view_idx]) {
      const View& source = scene.views[source_idx];
      if (const auto map = maps.Find(source.name)) {
        predictor.Add(source, map->depth, read_photograph(source));
      }
    }
    const PhotographPrediction prediction =
        predictor.Compare(read_photograph(view));
    sum.num_textured += prediction.num_textured;
    sum.num_wrong += prediction.num_wrong;
  }
  return sum;
}

}  // namespace structnerf
