#pragma once

#include <string>

#include <opencv2/core.hpp>

namespace structnerf {

// A photograph or mask as it is stored: COLMAP does not turn images as their
// EXIF data says, so neither do we. Empty if there is no whole image.
cv::Mat3b ReadColorImage(const std::string& path);  // blue, green, red
cv::Mat1b ReadGreyImage(const std::string& path);

}  // namespace structnerf
