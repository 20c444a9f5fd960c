#pragma once

#include <string>
#include <vector>

#include <opencv2/core.hpp>

namespace structnerf {

// A picture of depth, 8-bit BGR, in viridis, which any kind of colour vision
// can read. `depth` <= 0 = no value, shown grey; values outside of [nearest,
// farthest] are shown as the limit.
cv::Mat3b DepthPicture(const cv::Mat1f& depth, double nearest, double farthest);

// Red, green and blue are how far the normal points right, up and towards the
// camera, from -1 to 1. `normal`: three planes as in StereoMaps; (0, 0, 0) = no
// value, shown grey.
cv::Mat3b NormalPicture(const std::vector<float>& normal,
                        int width,
                        int height);

// A picture as the value of an <img>'s src.
std::string PngDataUri(const cv::Mat3b& picture);

}  // namespace structnerf
