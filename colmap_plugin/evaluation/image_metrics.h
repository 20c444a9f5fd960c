#pragma once

#include <opencv2/core.hpp>

namespace structnerf {

// Peak signal-to-noise ratio in dB of two colour images in [0, 1], at most 120
// (equal images).
double Psnr(const cv::Mat3f& image, const cv::Mat3f& reference);

// Mean structural similarity (Wang et al. 2004) of two colour images in
// [0, 1]: Gaussian windows of 11x11 pixels, sigma 1.5, K1 = 0.01, K2 = 0.03,
// mean over the channels and over all windows that lie inside. Throws
// std::runtime_error if an image is smaller than a window.
double Ssim(const cv::Mat3f& image, const cv::Mat3f& reference);

}  // namespace structnerf
