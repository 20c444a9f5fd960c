#pragma once

#include <string>

#include <opencv2/core.hpp>

namespace structnerf {

// A photograph or mask as it is stored: COLMAP does not turn images as their
// EXIF data says, so neither do we. Empty if there is no whole image.
cv::Mat3b ReadColorImage(const std::string& path);  // blue, green, red
cv::Mat1b ReadGreyImage(const std::string& path);

// Whether the end of a JPEG or PNG file is missing, as of one that was copied
// in part or written to a full disk. The libraries read such JPEGs without a
// word, the rest being grey. False for other files, and for what cannot be
// read.
bool IsCutOff(const std::string& path);

}  // namespace structnerf
