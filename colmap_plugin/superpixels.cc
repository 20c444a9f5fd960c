#include "colmap_plugin/superpixels.h"

#include <opencv2/core.hpp>
#include <opencv2/ximgproc/segmentation.hpp>

namespace structnerf {
namespace {

// OpenCV's defaults, which are those of the algorithm's authors except for the
// coarser scale.
constexpr double kSigma = 0.5;
constexpr float kScale = 300;
constexpr int kMinSize = 100;

}  // namespace

std::vector<int32_t> FindLargeSuperpixels(const RgbImage& image,
                                          const int min_area) {
  // OpenCV does not write through the pointer.
  const cv::Mat pixels(image.height,
                       image.width,
                       CV_8UC3,
                       const_cast<uint8_t*>(image.data.data()));
  cv::Mat labels;
  cv::ximgproc::segmentation::createGraphSegmentation(kSigma, kScale, kMinSize)
      ->processImage(pixels, labels);

  double max_label = 0;
  cv::minMaxLoc(labels, nullptr, &max_label);
  std::vector<int> areas(static_cast<size_t>(max_label) + 1, 0);
  for (const int label : cv::Mat_<int>(labels)) {
    ++areas[label];
  }
  std::vector<int32_t> new_labels(areas.size(), -1);
  int32_t num_labels = 0;
  for (size_t label = 0; label < areas.size(); ++label) {
    if (areas[label] >= min_area) {
      new_labels[label] = num_labels++;
    }
  }

  std::vector<int32_t> segments;
  segments.reserve(labels.total());
  for (const int label : cv::Mat_<int>(labels)) {
    segments.push_back(new_labels[label]);
  }
  return segments;
}

}  // namespace structnerf
