#include "colmap_plugin/evaluation/photograph_prediction.h"

#include "colmap_plugin/input_check.h"
#include "tests/colmap_plugin/tiny_model.h"
#include "tests/nerf/plane_scene.h"
#include "tests/support/temp_dir.h"

#include <filesystem>
#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace structnerf {
namespace {

using testing::HasSubstr;

constexpr int kWidth = 120;
constexpr int kHeight = 90;

// A view of a textured wall, moved sideways.
View PhotographedView(const TexturedPlane& plane, const double x) {
  View view = MakeView("a.jpg", MakeCamera(kWidth, kHeight, 100), {x, 0, 0});
  plane.Photograph(kWidth, kHeight, &view);
  return view;
}

cv::Mat1b GreyImage(const View& view) {
  cv::Mat1b grey(kHeight, kWidth);
  for (int i = 0; i < kWidth * kHeight; ++i) {
    grey(i) = view.image.data[3 * i];
  }
  return grey;
}

cv::Mat1f DepthMap(const TexturedPlane& plane,
                   const View& view,
                   const double factor = 1) {
  cv::Mat1f depth(kHeight, kWidth);
  for (int row = 0; row < kHeight; ++row) {
    for (int col = 0; col < kWidth; ++col) {
      depth(row, col) =
          static_cast<float>(factor * plane.Depth(view, col + 0.5, row + 0.5));
    }
  }
  return depth;
}

class PhotographPredictorTest : public testing::Test {
 protected:
  // Of the middle view, from those to its left and right.
  PhotographPrediction Predict(const double depth_factor,
                               const double gain = 1) const {
    PhotographPredictor predictor(view_);
    for (const double x : {-0.5, 0.5}) {
      const View source = PhotographedView(plane_, x);
      predictor.Add(
          source, DepthMap(plane_, source, depth_factor), GreyImage(source));
    }
    return predictor.Compare(gain * GreyImage(view_));
  }

  const TexturedPlane plane_;
  const View view_ = PhotographedView(plane_, 0);
};

TEST_F(PhotographPredictorTest, RightDepthPredictsWhatIsSeen) {
  const PhotographPrediction prediction = Predict(1);
  EXPECT_GT(prediction.num_textured, kWidth * kHeight / 2);
  EXPECT_LT(prediction.ShareWrong(), 0.02);
}

TEST_F(PhotographPredictorTest, WrongDepthDoesNot) {
  EXPECT_GT(Predict(1.6).ShareWrong(), 0.3);
  EXPECT_GT(Predict(0.7).ShareWrong(), 0.3);
}

TEST_F(PhotographPredictorTest, ExposureDoesNotMatter) {
  EXPECT_LT(Predict(1, 0.8).ShareWrong(), 0.02);
}

TEST_F(PhotographPredictorTest, PixelsWithoutDepthAreWrong) {
  EXPECT_EQ(Predict(0).ShareWrong(), 1);
}

TEST_F(PhotographPredictorTest, TheNearestHideWhatIsBehind) {
  PhotographPredictor predictor(view_);
  const View source = PhotographedView(plane_, 0.5);
  predictor.Add(source, DepthMap(plane_, source), GreyImage(source));
  TexturedPlane behind = plane_;
  behind.point.z() = 5;
  predictor.Add(source,
                DepthMap(behind, source),
                cv::Mat1b(kHeight, kWidth, uint8_t{255}));
  // Half a unit to the right, the left eighth of the wall is not seen.
  EXPECT_LT(predictor.Compare(GreyImage(view_)).ShareWrong(), 0.2);
}

TEST_F(PhotographPredictorTest, BlankPhotographsSayNothing) {
  const PhotographPrediction prediction = PhotographPredictor(view_).Compare(
      cv::Mat1b(kHeight, kWidth, uint8_t{100}));
  EXPECT_EQ(prediction.num_textured, 0u);
  EXPECT_EQ(prediction.ShareWrong(), 0);
}

TEST(PredictHeldOutPhotographs, NamesAnImageThatIsMissing) {
  const TempDir temp_dir;
  const DenseWorkspace workspace(temp_dir.Path().string());
  const TinyModel tiny = MakeTinyModel(3);
  tiny.WriteImages(workspace.ImagesPath());
  tiny.WriteModel(workspace.SparsePath());
  const colmap::Reconstruction model = ReadModel(workspace.SparsePath());
  EXPECT_GT(PredictHeldOutPhotographs(workspace, model, /*test_every=*/3)
                .num_textured,
            0u);
  std::filesystem::remove(workspace.ImagePath("2.png"));
  try {
    PredictHeldOutPhotographs(workspace, model, /*test_every=*/3);
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr("2.png cannot be read"));
  }
}

}  // namespace
}  // namespace structnerf
