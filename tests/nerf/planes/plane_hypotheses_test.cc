#include "nerf/planes/plane_hypotheses.h"

#include "nerf/planes/view_projection.h"
#include "nerf/util/random.h"
#include "tests/nerf/plane_scene.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

namespace structnerf {
namespace {

constexpr int kWidth = 160;
constexpr int kHeight = 120;
constexpr int kBorder = 6;
constexpr double kScale = 0.125;  // field units per world unit

// World depths of what the first view sees.
constexpr double kWall = 4;
constexpr double kOccluder = 2.5;
constexpr double kPresent = 3;  // of the blank segment, before

struct Area {
  int min_col, end_col, min_row, end_row;

  bool Contains(const int col, const int row) const {
    return col >= min_col && col < end_col && row >= min_row && row < end_row;
  }
};

// The blank part of a wall. The wall's texture is seen above it, an occluder's
// below. The camera is level, so both stand upright.
// The second view, 2.4 units to the right, is as grey as the first.
class PlaneHypothesesTest : public testing::Test {
 protected:
  PlaneHypothesesTest() : random_(7) {
    scene_.views = {
        MakeView(
            "view", MakeCamera(kWidth, kHeight, 150), Eigen::Vector3d::Zero()),
        MakeView("source",
                 MakeCamera(480, kHeight, 150),
                 Eigen::Vector3d(2.4, 0, 0))};
    scene_.views[0].image = PlainImage(kWidth, kHeight, 128);
    scene_.views[1].image = PlainImage(480, kHeight, 128);
    view_.segments.assign(kWidth * kHeight, -1);
    view_.width = kWidth;
    view_.height = kHeight;
    view_.camera = scene_.views[0].camera;
    view_.rho.assign(view_.segments.size(), RhoOfDepth(kPresent));
    view_.is_reliable.assign(view_.segments.size(), 0);
    Fill(kBlank, [&](const int col, const int row) {
      view_.segments[view_.Index(col, row)] = 0;
    });
  }

  static float RhoOfDepth(const double depth) {
    return static_cast<float>(1 / (kScale * depth));
  }

  template <typename Function>
  static void Fill(const Area& area, const Function& function) {
    for (int row = area.min_row; row < area.end_row; ++row) {
      for (int col = area.min_col; col < area.end_col; ++col) {
        function(col, row);
      }
    }
  }

  // Matches, up to a little noise.
  void SetReliable(const Area& area, const double depth) {
    Fill(area, [&](const int col, const int row) {
      const size_t index = view_.Index(col, row);
      view_.is_reliable[index] = 1;
      view_.rho[index] =
          RhoOfDepth(depth) * (1 + 0.006f * (random_.NextFloat() - 0.5f));
    });
  }

  void SetReliableAround() {
    SetReliable({0, kWidth, 20, kBlank.min_row}, kWall);
    SetReliable({0, kWidth, kBlank.end_row, kHeight}, kOccluder);
  }

  std::vector<std::vector<PlaneHypothesis>> Find() const {
    SceneFrame frame;
    frame.scale = kScale;
    const TrainingViews views(scene_, frame);
    return FindPlaneHypotheses(
        view_, kBorder, Eigen::Vector3f::UnitY(), 0, {Warp(views)}, {1}, views);
  }

  ViewWarp Warp(const TrainingViews& views) const {
    return MakeViewWarp(scene_.views[0],
                        scene_.views[1],
                        views.image(0),
                        views.image(1),
                        kScale);
  }

  // Whether one of the planes is within 2 % of this one in the blank segment.
  bool HasPlane(const std::vector<PlaneHypothesis>& planes,
                const Eigen::Vector3f& coefficients) const {
    return std::any_of(
        planes.begin(), planes.end(), [&](const PlaneHypothesis& plane) {
          float largest = 0;
          Fill(kBlank, [&](const int col, const int row) {
            const Eigen::Vector3f ray = view_.Ray(col, row);
            const float expected = coefficients.dot(ray);
            largest = std::max(
                largest, std::abs(plane.InverseDepth(ray) / expected - 1));
          });
          return largest < 0.02f;
        });
  }

  bool HasUpright(const std::vector<PlaneHypothesis>& planes,
                  const double depth) const {
    return HasPlane(planes, RhoOfDepth(depth) * Eigen::Vector3f::UnitZ());
  }

  static constexpr Area kBlank = {30, 130, 40, 91};

  Random random_;
  Scene scene_;
  PlaneView view_;
};

TEST_F(PlaneHypothesesTest, BordersNameTheWallAndWhatStandsBeforeIt) {
  SetReliableAround();
  const auto planes = Find();
  ASSERT_EQ(planes.size(), 1u);
  EXPECT_TRUE(HasUpright(planes[0], kWall));
  EXPECT_TRUE(HasUpright(planes[0], kOccluder));
  EXPECT_FALSE(HasUpright(planes[0], kPresent));
  for (const PlaneHypothesis& plane : planes[0]) {
    EXPECT_GT(plane.support, 0);
    EXPECT_LE(plane.support, 1);
    // All are upright or level, as far as their anchors leave them so.
    EXPECT_TRUE(std::abs(plane.coefficients.normalized().y()) < 0.1 ||
                std::abs(plane.coefficients.normalized().y()) > 0.99);
  }
}

TEST_F(PlaneHypothesesTest, SlantedWallsAreFound) {
  SetReliableAround();
  const Eigen::Vector3f wall = RhoOfDepth(kWall) * Eigen::Vector3f(0.6f, 0, 1);
  Fill({0, kWidth, 20, kBlank.min_row}, [&](const int col, const int row) {
    view_.rho[view_.Index(col, row)] = wall.dot(view_.Ray(col, row));
  });
  EXPECT_TRUE(HasPlane(Find()[0], wall));
}

TEST_F(PlaneHypothesesTest, WhatHasMuchInFrontInItsMiddleIsRefused) {
  SetReliableAround();
  // A picture's nail may be a false match.
  SetReliable({78, 82, 60, 64}, kPresent);
  EXPECT_TRUE(HasUpright(Find()[0], kWall));
  // Something as large as this is not.
  SetReliable({68, 92, 56, 72}, kPresent);
  EXPECT_FALSE(HasUpright(Find()[0], kWall));
}

TEST_F(PlaneHypothesesTest, WhatHasSomethingBehindItIsRefused) {
  SetReliableAround();
  SetReliable({60, 70, 60, 64}, kWall);
  const auto planes = Find();
  EXPECT_TRUE(HasUpright(planes[0], kWall));
  EXPECT_FALSE(HasUpright(planes[0], kOccluder));
}

TEST_F(PlaneHypothesesTest, OtherColorsElsewhereAreAVeto) {
  SetReliableAround();
  // All is as unlike before as it would be then.
  scene_.views[1].image = PlainImage(480, kHeight, 220);
  EXPECT_TRUE(HasUpright(Find()[0], kWall));

  // The colour is right at the present depth only.
  SceneFrame frame;
  frame.scale = kScale;
  const ViewWarp warp = Warp(TrainingViews(scene_, frame));
  Fill(kBlank, [&](const int col, const int row) {
    int source_col;
    int source_row;
    float ratio;
    ASSERT_TRUE(ProjectPixel(warp,
                             col,
                             row,
                             RhoOfDepth(kPresent),
                             &source_col,
                             &source_row,
                             &ratio));
    uint8_t* pixel =
        &scene_.views[1].image.data[3 * (source_row * 480 + source_col)];
    std::fill(pixel, pixel + 3, 128);
  });
  EXPECT_FALSE(HasUpright(Find()[0], kWall));

  // What is masked tells nothing.
  scene_.views[1].mask.assign(480 * kHeight, 0);
  EXPECT_TRUE(HasUpright(Find()[0], kWall));
}

TEST_F(PlaneHypothesesTest, TableTopsAreLevel) {
  // As high below the camera as the wall is far from it.
  const Eigen::Vector3f table = RhoOfDepth(1.2) * Eigen::Vector3f::UnitY();
  Fill({0, kWidth, 64, kHeight}, [&](const int col, const int row) {
    const size_t index = view_.Index(col, row);
    const bool is_blank = Area{30, 130, 72, 108}.Contains(col, row);
    view_.segments[index] = is_blank ? 0 : -1;
    view_.is_reliable[index] = !is_blank;
    view_.rho[index] =
        (is_blank ? 1.1f : 1.0f) * table.dot(view_.Ray(col, row));
  });
  Fill({0, kWidth, 0, 64}, [&](const int col, const int row) {
    view_.segments[view_.Index(col, row)] = -1;
  });
  const auto planes = Find();
  ASSERT_FALSE(planes[0].empty());
  // The most likely one.
  EXPECT_LT(
      (planes[0][0].coefficients / table.y() - Eigen::Vector3f::UnitY()).norm(),
      0.02f);
}

TEST_F(PlaneHypothesesTest, WithoutReliablePixelsThereAreNone) {
  const auto planes = Find();
  ASSERT_EQ(planes.size(), 1u);
  EXPECT_TRUE(planes[0].empty());
  // Too few of them fix nothing, either.
  SetReliable({80, 83, 39, 40}, kWall);
  EXPECT_TRUE(Find()[0].empty());
}

TEST_F(PlaneHypothesesTest, EachSegmentHasItsOwnPlanes) {
  SetReliableAround();
  // One without neighbours, one that has no pixels, and the wall.
  Fill(kBlank, [&](const int col, const int row) {
    view_.segments[view_.Index(col, row)] = 2;
  });
  Fill({0, 20, 0, 10}, [&](const int col, const int row) {
    view_.segments[view_.Index(col, row)] = 0;
  });
  const auto planes = Find();
  ASSERT_EQ(planes.size(), 3u);
  EXPECT_TRUE(planes[0].empty());
  EXPECT_TRUE(planes[1].empty());
  EXPECT_TRUE(HasUpright(planes[2], kWall));
}

TEST_F(PlaneHypothesesTest, WithoutSegmentsThereAreNone) {
  SetReliableAround();
  view_.segments.assign(view_.segments.size(), -1);
  EXPECT_TRUE(Find().empty());
}

}  // namespace
}  // namespace structnerf
