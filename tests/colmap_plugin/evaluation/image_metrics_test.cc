#include "colmap_plugin/evaluation/image_metrics.h"

#include <cmath>

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>
#include <opencv2/quality/qualityssim.hpp>

namespace structnerf {
namespace {

cv::Mat3f RandomColors(const int seed) {
  cv::Mat3f image(48, 64);
  cv::RNG random(seed);
  random.fill(image, cv::RNG::UNIFORM, 0, 1);
  cv::GaussianBlur(image, image, {5, 5}, 1);
  return image;
}

TEST(PsnrTest, OfAKnownDifference) {
  const cv::Mat3f image(10, 10, cv::Vec3f(0.5, 0.5, 0.5));
  EXPECT_NEAR(Psnr(image + cv::Scalar::all(0.1), image), 20, 1e-4);
  // One channel of three.
  EXPECT_NEAR(Psnr(image + cv::Scalar(0.1, 0, 0), image),
              20 + 10 * std::log10(3.0),
              1e-4);
  EXPECT_EQ(Psnr(image, image), 120);
}

// OpenCV has it for images of 8 bits and windows that reach over the border,
// which its map of the similarity lets one leave out.
TEST(SsimTest, AgreesWithOpenCv) {
  const cv::Mat3f reference = RandomColors(1);
  for (const double noise : {0.02, 0.1, 0.5}) {
    cv::Mat3b reference_levels;
    cv::Mat3b image_levels;
    reference.convertTo(reference_levels, CV_8U, 255);
    cv::Mat3f(reference + noise * (RandomColors(2) - cv::Scalar::all(0.5)))
        .convertTo(image_levels, CV_8U, 255);
    cv::Mat map;
    cv::quality::QualitySSIM::compute(image_levels, reference_levels, map);
    ASSERT_EQ(map.size(), reference.size());
    const cv::Scalar expected = cv::mean(map(cv::Rect(5, 5, 54, 38)));

    cv::Mat3f image;
    cv::Mat3f rounded_reference;
    image_levels.convertTo(image, CV_32F, 1.0 / 255);
    reference_levels.convertTo(rounded_reference, CV_32F, 1.0 / 255);
    EXPECT_NEAR(Ssim(image, rounded_reference),
                (expected[0] + expected[1] + expected[2]) / 3,
                1e-4)
        << noise;
  }
}

TEST(SsimTest, IsOneForEqualImagesOnly) {
  const cv::Mat3f image = RandomColors(1);
  EXPECT_NEAR(Ssim(image, image), 1, 1e-9);
  EXPECT_LT(Ssim(cv::Scalar::all(1) - image, image), 0);
}

TEST(SsimTest, RefusesImagesSmallerThanAWindow) {
  const cv::Mat3f image(10, 40, cv::Vec3f(0, 0, 0));
  EXPECT_THROW(Ssim(image, image), std::runtime_error);
}

}  // namespace
}  // namespace structnerf
