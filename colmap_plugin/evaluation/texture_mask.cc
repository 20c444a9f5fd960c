#include "colmap_plugin/evaluation/texture_mask.h"

#include <opencv2/imgproc.hpp>

namespace structnerf {
namespace {

constexpr int kWindow = 11;           // pixels
constexpr double kMinGradient = 4.0;  // grey levels per pixel

}  // namespace

cv::Mat1b TextureMask(const cv::Mat1b& image) {
  cv::Mat1f levels;
  image.convertTo(levels, CV_32F);
  cv::Mat gradient_x;
  cv::Mat gradient_y;
  cv::Sobel(levels, gradient_x, CV_32F, 1, 0, /*ksize=*/3, /*scale=*/1.0 / 8);
  cv::Sobel(levels, gradient_y, CV_32F, 0, 1, /*ksize=*/3, /*scale=*/1.0 / 8);
  cv::Mat energy = gradient_x.mul(gradient_x) + gradient_y.mul(gradient_y);
  cv::blur(energy, energy, {kWindow, kWindow});
  return energy >= kMinGradient * kMinGradient;
}

}  // namespace structnerf
