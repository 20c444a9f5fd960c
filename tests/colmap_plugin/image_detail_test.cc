#include "colmap_plugin/image_detail.h"

#include "tests/colmap_plugin/tiny_model.h"
#include "tests/support/temp_dir.h"

#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

namespace structnerf {
namespace {

cv::Mat Enlarged(const cv::Mat& image, const int factor) {
  cv::Mat enlarged;
  cv::resize(image, enlarged, {}, factor, factor, cv::INTER_CUBIC);
  return enlarged;
}

std::vector<std::string> WriteImages(const TempDir& folder,
                                     const std::vector<cv::Mat>& images) {
  std::vector<std::string> names;
  for (const cv::Mat& image : images) {
    names.push_back(std::to_string(names.size()) + ".png");
    cv::imwrite(folder / names.back(), image);
  }
  return names;
}

TEST(LostGreyLevels, OfOneColorIsNothing) {
  EXPECT_EQ(LostGreyLevels(cv::Mat(30, 40, CV_8U, cv::Scalar(99)), 0.5), 0);
  EXPECT_EQ(LostGreyLevels(cv::Mat(1, 1, CV_8U, cv::Scalar(99)), 0.5), 0);
}

TEST(LostGreyLevels, OfAFineCheckerboardIsItsContrast) {
  cv::Mat board(60, 80, CV_8U);
  for (int row = 0; row < board.rows; ++row) {
    for (int col = 0; col < board.cols; ++col) {
      board.at<uint8_t>(row, col) = (row + col) % 2 ? 120 : 80;
    }
  }
  EXPECT_NEAR(LostGreyLevels(board, 0.5), 20, 0.1);
}

TEST(MeasureImageDetail, SharpPhotographsKeepTheirSize) {
  const TempDir folder;
  const auto names =
      WriteImages(folder, {RandomImage(320, 240, 1), RandomImage(320, 240, 2)});
  const ImageDetail detail = MeasureImageDetail(folder.Path(), names, 320);
  EXPECT_EQ(detail.image_size, 320);
  EXPECT_EQ(detail.tried_size, 226);
  EXPECT_GT(detail.lost_grey_levels, 5);
}

TEST(MeasureImageDetail, EnlargedOnesAreReduced) {
  const TempDir folder;
  const cv::Mat small = RandomImage(80, 60, 1);
  const auto names = WriteImages(folder, {Enlarged(small, 8)});
  const ImageDetail detail = MeasureImageDetail(folder.Path(), names, 640);
  EXPECT_LE(detail.image_size, 320);
  EXPECT_GE(detail.image_size, 160);
  // The limit counts, not the size of the photographs.
  EXPECT_EQ(MeasureImageDetail(folder.Path(), names, 80).image_size, 80);
}

TEST(MeasureImageDetail, OneBlurredPhotographDoesNotDecide) {
  const TempDir folder;
  const auto names = WriteImages(folder,
                                 {RandomImage(320, 240, 1),
                                  Enlarged(RandomImage(40, 30, 2), 8),
                                  RandomImage(320, 240, 3)});
  EXPECT_EQ(MeasureImageDetail(folder.Path(), names, 320).image_size, 320);
}

TEST(MeasureImageDetail, NothingToSeeNeedsFewPixelsButSome) {
  const TempDir folder;
  const auto names =
      WriteImages(folder, {cv::Mat(480, 640, CV_8UC3, cv::Scalar::all(0))});
  EXPECT_EQ(MeasureImageDetail(folder.Path(), names, 640).image_size, 160);
  EXPECT_GE(MeasureImageDetail(folder.Path(), names, 100).image_size,
            kMinTrainingImageSize);
}

TEST(MeasureImageDetail, WithoutImagesNothingIsReduced) {
  const TempDir folder;
  const ImageDetail detail =
      MeasureImageDetail(folder.Path(), {"none.png"}, 320);
  EXPECT_EQ(detail.image_size, 320);
  EXPECT_EQ(detail.tried_size, 0);
}

}  // namespace
}  // namespace structnerf
