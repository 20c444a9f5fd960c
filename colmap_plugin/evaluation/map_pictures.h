#pragma once

#include <string>
#include <vector>

#include <opencv2/core.hpp>

namespace structnerf {

// Pictures of maps, 8-bit BGR. The colour scales are readable with any kind of
// colour vision: viridis for depth, inferno for errors, blue to orange for a
// balance. Pixels without a value are grey, which is in none of them.

// `depth` <= 0 = no value; values outside of [nearest, farthest] are shown as
// the limit.
cv::Mat3b DepthPicture(const cv::Mat1f& depth, double nearest, double farthest);

// `error` < 0 = no value; values above `largest` are shown as that.
cv::Mat3b ErrorPicture(const cv::Mat1f& error, double largest);

// Which of two errors, both of the same size, is smaller: blue where it is
// `a`'s, by up to `largest`, orange where it is `b`'s, white where they are
// equal. No value where one of the two has none.
cv::Mat3b BalancePicture(const cv::Mat1f& a,
                         const cv::Mat1f& b,
                         double largest);

// Red, green and blue are how far the normal points right, up and towards the
// camera, from -1 to 1. `normal`: three planes as in StereoMaps; (0, 0, 0) = no
// value.
cv::Mat3b NormalPicture(const std::vector<float>& normal,
                        int width,
                        int height);

// The scales from their lower to their upper end, one pixel high.
cv::Mat3b DepthScaleBar();
cv::Mat3b ErrorScaleBar();
cv::Mat3b BalanceScaleBar();

// A picture as the value of an <img>'s src: PNG, or JPEG for photographs and
// pictures that are like them. `max_size`: longest side in pixels that it is
// reduced to.
std::string PngDataUri(const cv::Mat3b& picture);
std::string JpegDataUri(const cv::Mat3b& picture, int max_size);

}  // namespace structnerf
