#pragma once

#include <string>

#include <opencv2/core.hpp>

namespace structnerf {

// A picture of depth, 8-bit BGR, in viridis, which any kind of colour vision
// can read. `depth` <= 0 = no value, shown grey; values outside of [nearest,
// farthest] are shown as the limit.
cv::Mat3b DepthPicture(const cv::Mat1f& depth, double nearest, double farthest);

// A picture as the value of an <img>'s src.
std::string PngDataUri(const cv::Mat3b& picture);

}  // namespace structnerf
