#include "colmap_plugin/evaluation/depth_truth.h"

#include "tests/support/temp_dir.h"

#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

namespace structnerf {
namespace {

using testing::HasSubstr;

class DepthTruthTest : public testing::Test {
 protected:
  DepthTruthTest() {
    options_.path = temp_dir_.Path();
    camera_ = colmap::Camera::CreateFromModelName(1, "PINHOLE", 50, 4, 2);
  }

  void Write(const std::string& name, const cv::Mat& image) const {
    const std::filesystem::path path = temp_dir_ / name;
    std::filesystem::create_directories(path.parent_path());
    ASSERT_TRUE(cv::imwrite(path.string(), image));
  }

  std::string ReadError(const std::string& name) const {
    try {
      DepthTruth(options_).Read(name, camera_);
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "";
  }

  TempDir temp_dir_;
  DepthTruthOptions options_;
  colmap::Camera camera_;
};

TEST_F(DepthTruthTest, ReadsMetres) {
  Write("a/b.png",
        (cv::Mat_<uint16_t>(2, 4) << 0, 65535, 500, 1000, 1500, 2000, 2500, 3));
  options_.min_depth = 0.1;
  options_.max_depth = 2;
  const cv::Mat1f depth = DepthTruth(options_).Read("a/b.jpg", camera_);
  const cv::Mat1f expected = (cv::Mat1f(2, 4) << 0, 0, 0.5, 1, 1.5, 2, 0, 0);
  EXPECT_EQ(cv::norm(depth, expected, cv::NORM_INF), 0);

  options_.scale = 500;
  options_.max_depth = 0;
  EXPECT_FLOAT_EQ(DepthTruth(options_).Read("a/b.jpg", camera_)(1, 2), 5);
}

TEST_F(DepthTruthTest, FindsBothWaysOfNaming) {
  const cv::Mat image(2, 4, CV_16UC1, cv::Scalar(1000));
  Write("x.png", image);
  Write("y.jpg.png", image);
  const DepthTruth truth(options_);
  EXPECT_TRUE(truth.Has("x.jpg"));
  EXPECT_TRUE(truth.Has("y.jpg"));
  EXPECT_FALSE(truth.Has("z.jpg"));
  EXPECT_EQ(truth.Read("y.jpg", camera_)(0, 0), 1);
}

TEST_F(DepthTruthTest, MaskedTruthIsLeftOut) {
  Write("depth/x.png", cv::Mat(2, 4, CV_16UC1, cv::Scalar(1000)));
  Write("masks/x.png", (cv::Mat1b(2, 4) << 0, 255, 255, 1, 0, 0, 0, 255));
  options_.path = temp_dir_ / "depth";
  const cv::Mat1f all = cv::Mat1f::ones(2, 4);
  const auto difference = [&](const cv::Mat1f& depth, const cv::Mat1f& other) {
    return cv::norm(depth, other, cv::NORM_INF);
  };
  EXPECT_EQ(difference(DepthTruth(options_).ReadMasked("x.jpg", camera_), all),
            0);

  options_.mask_path = temp_dir_ / "masks";
  const DepthTruth truth(options_);
  const cv::Mat1f expected = (cv::Mat1f(2, 4) << 0, 1, 1, 1, 0, 0, 0, 1);
  EXPECT_EQ(difference(truth.ReadMasked("x.jpg", camera_), expected), 0);
  EXPECT_EQ(difference(truth.Read("x.jpg", camera_), all), 0);

  // Of another size.
  Write("masks/x.png", (cv::Mat1b(1, 2) << 0, 255));
  const cv::Mat1f right = (cv::Mat1f(2, 4) << 0, 0, 1, 1, 0, 0, 1, 1);
  EXPECT_EQ(difference(truth.ReadMasked("x.jpg", camera_), right), 0);

  Write("depth/y.png", cv::Mat(2, 4, CV_16UC1, cv::Scalar(1000)));
  EXPECT_THROW(truth.ReadMasked("y.jpg", camera_), std::runtime_error);
  options_.mask_path = temp_dir_ / "none";
  EXPECT_THROW(DepthTruth{options_}, std::runtime_error);
}

TEST_F(DepthTruthTest, NamesTheFileThatIsWrong) {
  Write("grey.png", cv::Mat(2, 4, CV_8UC1, cv::Scalar(10)));
  EXPECT_THAT(ReadError("grey.jpg"), HasSubstr("grey.png is not a 16-bit"));
  Write("square.png", cv::Mat(4, 4, CV_16UC1, cv::Scalar(1000)));
  EXPECT_THAT(ReadError("square.jpg"), HasSubstr("square.png is 4x4"));
  EXPECT_THAT(ReadError("square.jpg"), HasSubstr("4x2"));
  EXPECT_THAT(ReadError("none.jpg"), HasSubstr("cannot be read"));
}

TEST_F(DepthTruthTest, RefusesAScaleThatCannotBe) {
  Write("x.png", cv::Mat(2, 4, CV_16UC1, cv::Scalar(2000)));
  options_.scale = 1;
  EXPECT_THAT(ReadError("x.jpg"), HasSubstr("--depth_scale 1 "));
  options_.scale = 1e6;
  EXPECT_THAT(ReadError("x.jpg"), HasSubstr("--depth_scale"));
  options_.scale = 0;
  EXPECT_THAT(ReadError("x.jpg"), HasSubstr("must be positive"));
}

TEST_F(DepthTruthTest, NamesTheOptionThatIsWrong) {
  options_.path = temp_dir_ / "none";
  EXPECT_THAT(ReadError("x.jpg"), HasSubstr("--ground_truth_path"));
  options_.path = temp_dir_.Path();
  options_.min_depth = 3;
  options_.max_depth = 2;
  EXPECT_THAT(ReadError("x.jpg"), HasSubstr("--min_depth"));
}

}  // namespace
}  // namespace structnerf
