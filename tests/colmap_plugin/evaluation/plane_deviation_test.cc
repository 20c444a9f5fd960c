#include "colmap_plugin/evaluation/plane_deviation.h"

#include "colmap_plugin/evaluation/pixel_lookup.h"
#include "tests/nerf/plane_scene.h"

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

namespace structnerf {
namespace {

class PlaneDeviationTest : public testing::Test {
 protected:
  static constexpr int kWidth = 80;
  static constexpr int kHeight = 60;

  PlaneDeviationTest()
      : view_(MakeView("view", MakeCamera(kWidth, kHeight, 70), {0, 0, 0})) {
    plane_.normal = {0.4, 0.2, -1};
  }

  // The plane moved along its normal by `shift`, every other row against it.
  cv::Mat1f Depth(const double shift) const {
    cv::Mat1f depth(kHeight, kWidth);
    for (int row = 0; row < kHeight; ++row) {
      TexturedPlane moved = plane_;
      moved.point +=
          (row % 2 == 0 ? shift : -shift) * plane_.normal.normalized();
      for (int col = 0; col < kWidth; ++col) {
        depth(row, col) =
            static_cast<float>(moved.Depth(view_, col + 0.5, row + 0.5));
      }
    }
    return depth;
  }

  View view_;
  TexturedPlane plane_;
  std::vector<int32_t> one_region_ = std::vector<int32_t>(kWidth * kHeight, 0);
};

TEST_F(PlaneDeviationTest, APlaneHasNone) {
  PlaneDeviation deviation;
  deviation.AddView(view_.camera, kPixelCenter, one_region_, Depth(0));
  EXPECT_EQ(deviation.NumPlanes(), 1);
  EXPECT_EQ(deviation.NumPoints(), kWidth * kHeight);
  EXPECT_LT(deviation.Mean(), 1e-5);
}

TEST_F(PlaneDeviationTest, IsTheDistanceToThePlane) {
  PlaneDeviation deviation;
  deviation.AddView(view_.camera, kPixelCenter, one_region_, Depth(0.02));
  EXPECT_NEAR(deviation.Mean(), 0.02, 2e-4);
}

TEST_F(PlaneDeviationTest, RegionsAreFittedOnTheirOwn) {
  // Two planes, left and right.
  cv::Mat1f depth = Depth(0);
  depth.colRange(kWidth / 2, kWidth) = 2.0f;
  std::vector<int32_t> labels = one_region_;
  for (size_t i = 0; i < labels.size(); ++i) {
    labels[i] = i % kWidth < kWidth / 2 ? 0 : 2;
  }
  PlaneDeviation apart;
  apart.AddView(view_.camera, kPixelCenter, labels, depth);
  EXPECT_EQ(apart.NumPlanes(), 2);
  EXPECT_LT(apart.Mean(), 1e-5);
  PlaneDeviation together;
  together.AddView(view_.camera, kPixelCenter, one_region_, depth);
  EXPECT_GT(together.Mean(), 0.05);
}

TEST_F(PlaneDeviationTest, LeavesOutPixelsAndRegionsWithoutDepth) {
  cv::Mat1f depth = Depth(0.02);
  depth.rowRange(0, 20) = 0;
  std::vector<int32_t> labels = one_region_;
  std::fill(labels.begin(), labels.begin() + kWidth, -1);
  PlaneDeviation deviation;
  deviation.AddView(view_.camera, kPixelCenter, labels, depth);
  EXPECT_EQ(deviation.NumPoints(), kWidth * 40);
  depth.rowRange(20, 40) = 0;
  PlaneDeviation none;
  none.AddView(view_.camera, kPixelCenter, labels, depth);
  EXPECT_EQ(none.NumPlanes(), 0);
  EXPECT_EQ(none.Mean(), 0);
}

TEST(FindPlanarRegionsTest, AreLargerThanAThousandPixels) {
  cv::Mat3b image(100, 100, cv::Vec3b(40, 40, 40));
  cv::rectangle(image, {10, 10, 60, 60}, {200, 80, 80}, cv::FILLED);
  cv::rectangle(image, {80, 80, 15, 15}, {80, 200, 80}, cv::FILLED);
  const auto labels = FindPlanarRegions(image);
  EXPECT_GE(labels[40 * 100 + 40], 0);
  EXPECT_NE(labels[40 * 100 + 40], labels[0]);
  EXPECT_EQ(labels[87 * 100 + 87], -1);
}

}  // namespace
}  // namespace structnerf
