#pragma once

#include <string>
#include <vector>

#include <opencv2/core.hpp>

namespace structnerf {

// Images are never reduced to less.
constexpr int kMinTrainingImageSize = 64;

// How small photographs can be made before anything that they show is lost.
struct ImageDetail {
  // Longest side in pixels.
  int image_size = 0;

  // The smallest size that was tried, and what is lost at it, in grey levels of
  // 255 (root of the mean square); 0 if nothing was measured.
  int tried_size = 0;
  double lost_grey_levels = 0;
};

// What `grey` (8 bits), enlarged again, differs by from itself after it has
// been made so much smaller, in grey levels (root of the mean square).
//   factor: of the width and height, in (0, 1).
double LostGreyLevels(const cv::Mat& grey, double factor);

// Of a few of the images below `image_path`, no larger than `max_image_size`:
// each size is 1/sqrt(2) of the one before, down to a quarter, as long as less
// is lost than noise and rounding amount to. In the median of the images, so
// that a single blurred one does not decide. Images that cannot be read are
// left out; without any, the answer is `max_image_size`.
ImageDetail MeasureImageDetail(const std::string& image_path,
                               const std::vector<std::string>& image_names,
                               int max_image_size);

}  // namespace structnerf
