#include "colmap_plugin/evaluation/map_pictures.h"

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

namespace structnerf {
namespace {

const cv::Vec3b kGrey(128, 128, 128);

int Brightness(const cv::Vec3b& color) {
  return color[0] + color[1] + color[2];
}

TEST(DepthPictureTest, GrowsBrighterBetweenItsLimits) {
  const cv::Mat1f depth = (cv::Mat1f(1, 6) << 0, 0.5, 1, 2, 3, 9);
  const cv::Mat3b picture = DepthPicture(depth, 1, 3);
  EXPECT_EQ(picture(0, 0), kGrey);
  EXPECT_EQ(picture(0, 1), picture(0, 2));
  EXPECT_LT(Brightness(picture(0, 2)), Brightness(picture(0, 3)));
  EXPECT_LT(Brightness(picture(0, 3)), Brightness(picture(0, 4)));
  EXPECT_EQ(picture(0, 4), picture(0, 5));
  // The ends are those of the scale beside the pictures.
  EXPECT_EQ(picture(0, 2), DepthScaleBar()(0, 0));
  EXPECT_EQ(picture(0, 4), DepthScaleBar()(0, 255));
}

TEST(ErrorPictureTest, ZeroIsAValue) {
  const cv::Mat1f error = (cv::Mat1f(1, 4) << -1, 0, 0.1, 5);
  const cv::Mat3b picture = ErrorPicture(error, 0.1);
  EXPECT_EQ(picture(0, 0), kGrey);
  EXPECT_EQ(picture(0, 1), ErrorScaleBar()(0, 0));
  EXPECT_EQ(picture(0, 2), ErrorScaleBar()(0, 255));
  EXPECT_EQ(picture(0, 3), picture(0, 2));
}

TEST(BalancePictureTest, IsBlueWhereTheFirstErrorIsSmaller) {
  const cv::Mat1f a = (cv::Mat1f(1, 5) << 0, 0.3, 0.1, -1, 0.1);
  const cv::Mat1f b = (cv::Mat1f(1, 5) << 0.3, 0, 0.1, 0.1, -1);
  const cv::Mat3b picture = BalancePicture(a, b, 0.2);
  EXPECT_EQ(picture(0, 0), BalanceScaleBar()(0, 0));
  EXPECT_GT(picture(0, 0)[0], picture(0, 0)[2] + 50);
  EXPECT_EQ(picture(0, 1), BalanceScaleBar()(0, 255));
  EXPECT_GT(picture(0, 1)[2], picture(0, 1)[0] + 50);
  EXPECT_GT(Brightness(picture(0, 2)), 3 * 240);
  EXPECT_EQ(picture(0, 3), kGrey);
  EXPECT_EQ(picture(0, 4), kGrey);
}

TEST(ScaleBarTest, NoColorOfAScaleLooksLikeNoValue) {
  for (const cv::Mat3b& bar :
       {DepthScaleBar(), ErrorScaleBar(), BalanceScaleBar()}) {
    for (const cv::Vec3b& color : bar) {
      EXPECT_GT(cv::norm(color, kGrey), 60) << color;
    }
  }
}

TEST(NormalPictureTest, RightIsRedUpIsGreenTowardsTheCameraIsBlue) {
  // Four pixels: x planes, y planes, z planes; y points down in the camera.
  const std::vector<float> normal = {1, 0, 0, 0, 0, -1, 0, 0, 0, 0, -1, 0};
  const cv::Mat3b picture = NormalPicture(normal, 4, 1);
  EXPECT_EQ(picture(0, 0), cv::Vec3b(128, 128, 255));
  EXPECT_EQ(picture(0, 1), cv::Vec3b(128, 255, 128));
  EXPECT_EQ(picture(0, 2), cv::Vec3b(255, 128, 128));
  EXPECT_EQ(picture(0, 3), kGrey);
}

// Decodes base64 by the book, to see whether the encoder pads as it must.
std::vector<uint8_t> DecodeBase64(const std::string& text) {
  const std::string letters =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  EXPECT_EQ(text.size() % 4, 0);
  std::vector<uint8_t> data;
  unsigned bits = 0;
  int num_bits = 0;
  for (const char c : text) {
    if (c == '=') {
      break;
    }
    EXPECT_NE(letters.find(c), std::string::npos);
    bits = (bits << 6) | static_cast<unsigned>(letters.find(c));
    num_bits += 6;
    if (num_bits >= 8) {
      num_bits -= 8;
      data.push_back(static_cast<uint8_t>(bits >> num_bits));
    }
  }
  return data;
}

TEST(DataUriTest, HoldsThePicture) {
  const std::string prefix = "data:image/png;base64,";
  // Files of several lengths, so that all paddings occur.
  for (int width = 1; width < 8; ++width) {
    cv::Mat3b picture(3, width);
    cv::RNG random(width);
    random.fill(picture, cv::RNG::UNIFORM, 0, 256);
    const std::string uri = PngDataUri(picture);
    ASSERT_EQ(uri.compare(0, prefix.size(), prefix), 0);
    const cv::Mat decoded =
        cv::imdecode(DecodeBase64(uri.substr(prefix.size())), cv::IMREAD_COLOR);
    ASSERT_EQ(decoded.size(), picture.size());
    EXPECT_EQ(cv::norm(decoded, picture, cv::NORM_INF), 0);
  }
}

TEST(DataUriTest, JpegIsReducedButNeverEnlarged) {
  const std::string prefix = "data:image/jpeg;base64,";
  const cv::Mat3b picture(30, 60, cv::Vec3b(10, 100, 200));
  for (const auto& [max_size, width] : {std::pair(20, 20), std::pair(99, 60)}) {
    const std::string uri = JpegDataUri(picture, max_size);
    ASSERT_EQ(uri.compare(0, prefix.size(), prefix), 0);
    const cv::Mat decoded =
        cv::imdecode(DecodeBase64(uri.substr(prefix.size())), cv::IMREAD_COLOR);
    EXPECT_EQ(decoded.size(), cv::Size(width, width / 2));
  }
}

}  // namespace
}  // namespace structnerf
