#include "colmap_plugin/image_detail.h"

#include "colmap_plugin/image_file.h"
#include "nerf/util/median.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include <opencv2/imgproc.hpp>

namespace structnerf {
namespace {

constexpr size_t kMaxNumImages = 5;

// Sharp photographs of rooms lose 3 to 6 at half of 640 pixels, blurred ones
// less than one.
constexpr double kMaxLostGreyLevels = 1.5;

constexpr int kNumSizes = 4;
const double kSizeFactor = std::sqrt(0.5);

cv::Mat Resized(const cv::Mat& image, const cv::Size& size, const int method) {
  cv::Mat resized;
  cv::resize(image, resized, size, 0, 0, method);
  return resized;
}

cv::Size SizeTimes(const cv::Mat& image, const double factor) {
  return {std::max(1, static_cast<int>(std::round(image.cols * factor))),
          std::max(1, static_cast<int>(std::round(image.rows * factor)))};
}

// At most `max_image_size` long; empty if it cannot be read.
cv::Mat ReadSmallGrey(const std::string& path, const int max_image_size) {
  const cv::Mat image = ReadGreyImage(path);
  const int longest_side = std::max(image.cols, image.rows);
  if (longest_side <= max_image_size) {
    return image;
  }
  return Resized(
      image,
      SizeTimes(image, static_cast<double>(max_image_size) / longest_side),
      cv::INTER_AREA);
}

}  // namespace

double LostGreyLevels(const cv::Mat& grey, const double factor) {
  const cv::Mat reduced =
      Resized(grey, SizeTimes(grey, factor), cv::INTER_AREA);
  const cv::Mat enlarged = Resized(reduced, grey.size(), cv::INTER_CUBIC);
  return cv::norm(grey, enlarged, cv::NORM_L2) /
         std::sqrt(static_cast<double>(grey.total()));
}

ImageDetail MeasureImageDetail(const std::string& image_path,
                               const std::vector<std::string>& image_names,
                               const int max_image_size) {
  std::vector<double> lost[kNumSizes];
  int longest_side = 0;
  const size_t num_images = std::min(kMaxNumImages, image_names.size());
  for (size_t i = 0; i < num_images; ++i) {
    const std::string& name = image_names[i * image_names.size() / num_images];
    const cv::Mat grey = ReadSmallGrey(
        (std::filesystem::path(image_path) / name).string(), max_image_size);
    if (grey.empty()) {
      continue;
    }
    longest_side = std::max({longest_side, grey.cols, grey.rows});
    for (int size = 0; size < kNumSizes; ++size) {
      lost[size].push_back(
          LostGreyLevels(grey, std::pow(kSizeFactor, size + 1)));
    }
  }
  ImageDetail detail{max_image_size};
  for (int size = 0; size < kNumSizes && longest_side > 0; ++size) {
    detail.tried_size = static_cast<int>(
        std::round(longest_side * std::pow(kSizeFactor, size + 1)));
    detail.lost_grey_levels = Median(&lost[size]);
    if (detail.lost_grey_levels > kMaxLostGreyLevels ||
        detail.tried_size < kMinTrainingImageSize) {
      break;
    }
    detail.image_size = detail.tried_size;
  }
  return detail;
}

}  // namespace structnerf
