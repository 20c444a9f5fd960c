#include "colmap_plugin/image_file.h"

#include <opencv2/imgcodecs.hpp>

namespace structnerf {

cv::Mat3b ReadColorImage(const std::string& path) {
  return cv::imread(path, cv::IMREAD_COLOR | cv::IMREAD_IGNORE_ORIENTATION);
}

cv::Mat1b ReadGreyImage(const std::string& path) {
  return cv::imread(path, cv::IMREAD_GRAYSCALE | cv::IMREAD_IGNORE_ORIENTATION);
}

}  // namespace structnerf
