#include "nerf/planes/view_projection.h"

#include "tests/nerf/plane_scene.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

namespace structnerf {
namespace {

constexpr double kScale = 0.125;  // field units per world unit

// Two views whose images are smaller than their cameras, in different ways.
class ViewProjectionTest : public testing::Test {
 protected:
  ViewProjectionTest()
      : view_(MakeView("view",
                       MakeCamera(64, 48, 70),
                       Eigen::Vector3d(100, 20, -30),
                       Eigen::Vector3d(0.1, 0.05, 1))),
        source_(MakeView("source",
                         MakeCamera(80, 60, 75),
                         Eigen::Vector3d(100.6, 20.2, -29.7),
                         Eigen::Vector3d(-0.1, 0.1, 1))) {
    image_.width = 32;
    image_.height = 24;
    source_image_.width = 50;
    source_image_.height = 40;
  }

  ViewWarp Warp() const {
    return MakeViewWarp(view_, source_, image_, source_image_, kScale);
  }

  // Depth of the pixel's centre and image point in the source's training image,
  // in double precision.
  Eigen::Vector3d Expected(const int col,
                           const int row,
                           const double depth) const {
    View view = view_;
    view.camera = view_.camera.Resized(image_.width, image_.height);
    View source = source_;
    source.camera =
        source_.camera.Resized(source_image_.width, source_image_.height);
    return Project(source, Unproject(view, col + 0.5, row + 0.5, depth));
  }

  View view_;
  View source_;
  TrainingViews::Image image_;
  TrainingViews::Image source_image_;
};

TEST_F(ViewProjectionTest, AgreesWithDoublePrecision) {
  const ViewWarp warp = Warp();
  int num_inside = 0;
  int num_outside = 0;
  for (const double depth : {1.5, 4.0, 40.0}) {
    for (int row = 0; row < image_.height; ++row) {
      for (int col = 0; col < image_.width; ++col) {
        const Eigen::Vector3d expected = Expected(col, row, depth);
        // Rounding decides where exactly a pixel ends.
        const Eigen::Vector2d to_edge =
            (expected.head<2>().array() - expected.head<2>().array().round());
        if (to_edge.cwiseAbs().minCoeff() < 1e-3) {
          continue;
        }
        int source_col = -1;
        int source_row = -1;
        float depth_ratio = 0;
        const bool is_inside = expected.x() > 0 && expected.y() > 0 &&
                               expected.x() < source_image_.width &&
                               expected.y() < source_image_.height;
        ASSERT_EQ(ProjectPixel(warp,
                               col,
                               row,
                               static_cast<float>(1 / (kScale * depth)),
                               &source_col,
                               &source_row,
                               &depth_ratio),
                  is_inside)
            << col << " " << row << " " << depth;
        if (is_inside) {
          EXPECT_EQ(source_col, std::floor(expected.x()));
          EXPECT_EQ(source_row, std::floor(expected.y()));
          EXPECT_NEAR(depth_ratio, expected.z() / depth, 1e-4);
        }
        num_inside += is_inside;
        num_outside += !is_inside;
      }
    }
  }
  EXPECT_GT(num_inside, 500);
  EXPECT_GT(num_outside, 100);
}

TEST_F(ViewProjectionTest, AtInverseDepthZeroIsInfinitelyFar) {
  int source_col;
  int source_row;
  float depth_ratio;
  ASSERT_TRUE(
      ProjectPixel(Warp(), 16, 12, 0, &source_col, &source_row, &depth_ratio));
  const Eigen::Vector3d expected = Expected(16, 12, 1e7);
  EXPECT_NEAR(source_col + 0.5, expected.x(), 0.51);
  EXPECT_NEAR(source_row + 0.5, expected.y(), 0.51);
  EXPECT_NEAR(depth_ratio, expected.z() / 1e7, 1e-4);
}

TEST_F(ViewProjectionTest, BehindTheSourceIsNothing) {
  // Five world units ahead, looking back the same way.
  source_ = MakeView("ahead",
                     source_.camera,
                     view_.ProjectionCenter() +
                         5 * view_.cam_from_world_rotation.row(2).transpose(),
                     view_.cam_from_world_rotation.row(2));
  const ViewWarp warp = Warp();
  int source_col;
  int source_row;
  float depth_ratio;
  const auto is_seen = [&](const double depth) {
    return ProjectPixel(warp,
                        16,
                        12,
                        static_cast<float>(1 / (kScale * depth)),
                        &source_col,
                        &source_row,
                        &depth_ratio);
  };
  EXPECT_TRUE(is_seen(8));
  EXPECT_NEAR(depth_ratio, 3.0 / 8, 1e-4);
  EXPECT_FALSE(is_seen(3));
  EXPECT_FALSE(is_seen(5));
}

TEST_F(ViewProjectionTest, WhatIsNoNumberIsNowhere) {
  int source_col;
  int source_row;
  float depth_ratio;
  for (const float rho : {std::numeric_limits<float>::quiet_NaN(),
                          std::numeric_limits<float>::infinity(),
                          -std::numeric_limits<float>::infinity()}) {
    EXPECT_FALSE(ProjectPixel(
        Warp(), 16, 12, rho, &source_col, &source_row, &depth_ratio));
  }
}

}  // namespace
}  // namespace structnerf
