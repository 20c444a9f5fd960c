#include "colmap_plugin/evaluation/image_metrics.h"

#include <cmath>
#include <stdexcept>

#include <opencv2/imgproc.hpp>

namespace structnerf {
namespace {

constexpr double kMinMeanSquare = 1e-12;

constexpr int kWindow = 11;  // pixels
constexpr double kSigma = 1.5;
constexpr double kC1 = 0.01 * 0.01;
constexpr double kC2 = 0.03 * 0.03;

cv::Mat Blur(const cv::Mat& image) {
  cv::Mat blurred;
  cv::GaussianBlur(image, blurred, {kWindow, kWindow}, kSigma);
  return blurred;
}

}  // namespace

double Psnr(const cv::Mat3f& image, const cv::Mat3f& reference) {
  const double norm = cv::norm(image, reference, cv::NORM_L2);
  const double mean_square = norm * norm / (3.0 * image.total());
  return -10 * std::log10(std::max(mean_square, kMinMeanSquare));
}

double Ssim(const cv::Mat3f& image, const cv::Mat3f& reference) {
  if (image.cols < kWindow || image.rows < kWindow) {
    throw std::runtime_error("An image is too small for SSIM, which needs " +
                             std::to_string(kWindow) + " pixels each way.");
  }
  // In double: variances are differences of squares.
  cv::Mat x;
  cv::Mat y;
  image.convertTo(x, CV_64F);
  reference.convertTo(y, CV_64F);
  const cv::Mat mean_x = Blur(x);
  const cv::Mat mean_y = Blur(y);
  const cv::Mat mean_xy = mean_x.mul(mean_y);
  const cv::Mat mean_xx_yy = mean_x.mul(mean_x) + mean_y.mul(mean_y);
  const cv::Mat covariance = Blur(x.mul(y)) - mean_xy;
  const cv::Mat variances = Blur(x.mul(x)) + Blur(y.mul(y)) - mean_xx_yy;
  const cv::Scalar c1 = cv::Scalar::all(kC1);
  const cv::Scalar c2 = cv::Scalar::all(kC2);
  cv::Mat numerator = 2 * mean_xy + c1;
  numerator = numerator.mul(2 * covariance + c2);
  cv::Mat denominator = mean_xx_yy + c1;
  denominator = denominator.mul(variances + c2);
  const cv::Mat similarity = numerator / denominator;
  const int border = kWindow / 2;
  const cv::Scalar mean = cv::mean(similarity(cv::Rect(
      border, border, image.cols - 2 * border, image.rows - 2 * border)));
  return (mean[0] + mean[1] + mean[2]) / 3;
}

}  // namespace structnerf
