#include "colmap_plugin/evaluation/pixel_lookup.h"

#include "tests/support/synthetic_camera.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

namespace structnerf {
namespace {

colmap::Camera MakeColmapCamera(const SyntheticCamera& camera) {
  colmap::Camera colmap_camera = colmap::Camera::CreateFromModelName(
      1, camera.model, 1, camera.width, camera.height);
  colmap_camera.params = camera.params;
  return colmap_camera;
}

cv::Mat1f RandomDepth(const int width, const int height) {
  cv::Mat1f depth(height, width);
  cv::RNG random(1);
  random.fill(depth, cv::RNG::UNIFORM, 1, 5);
  return depth;
}

class PixelLookupTest : public testing::TestWithParam<std::string> {
 protected:
  const SyntheticCamera distorted_ =
      SyntheticCamera::Make(GetParam(), 160, 120, 1);
  // Not of the same size, nor with the same field of view.
  const SyntheticCamera undistorted_{"PINHOLE", 170, 126, {150, 152, 84, 62}};
};

// Depth that is random from pixel to pixel, carried over by cameras that are
// not COLMAP's: any shift of half a pixel would show.
TEST_P(PixelLookupTest, FindsWhatEachPixelSees) {
  const cv::Mat1f map = RandomDepth(undistorted_.width, undistorted_.height);
  for (const cv::Size size : {cv::Size(160, 120), cv::Size(80, 60)}) {
    const cv::Mat1f found =
        LookUp(GridRays(MakeColmapCamera(distorted_), size, kPixelCenter),
               MakeColmapCamera(undistorted_),
               map);
    ASSERT_EQ(found.size(), size);
    int num_inside = 0;
    int num_different = 0;
    for (int row = 0; row < size.height; ++row) {
      for (int col = 0; col < size.width; ++col) {
        const Eigen::Vector2d point = undistorted_.Project(distorted_.Unproject(
            {(col + 0.5) * distorted_.width / size.width,
             (row + 0.5) * distorted_.height / size.height}));
        float expected = 0;
        if (point.x() >= 0 && point.y() >= 0 && point.x() < map.cols &&
            point.y() < map.rows) {
          expected =
              map(static_cast<int>(point.y()), static_cast<int>(point.x()));
          ++num_inside;
        }
        num_different += found(row, col) != expected;
      }
    }
    EXPECT_GT(num_inside, 0.7 * size.area());
    // Rays that meet the edge between two pixels may fall to either.
    EXPECT_LE(num_different, 2);
  }
}

INSTANTIATE_TEST_SUITE_P(Models,
                         PixelLookupTest,
                         testing::Values("PINHOLE", "SIMPLE_RADIAL", "OPENCV"),
                         [](const auto& info) { return info.param; });

TEST(LookUpTest, AReducedMapCoversTheWholeImage) {
  const colmap::Camera camera =
      MakeColmapCamera({"PINHOLE", 8, 4, {8, 8, 4, 2}});
  const cv::Mat1f map = RandomDepth(4, 2);
  const cv::Mat1f found =
      LookUp(GridRays(camera, {8, 4}, kPixelCenter), camera, map);
  for (int row = 0; row < 4; ++row) {
    for (int col = 0; col < 8; ++col) {
      EXPECT_EQ(found(row, col), map(row / 2, col / 2));
    }
  }
}

TEST(LookUpTest, TakesOnlyPositiveNumbers) {
  const colmap::Camera camera =
      MakeColmapCamera({"PINHOLE", 4, 1, {4, 4, 2, 0}});
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float infinity = std::numeric_limits<float>::infinity();
  const cv::Mat1f map = (cv::Mat1f(1, 4) << nan, infinity, -1, 2);
  const cv::Mat1f found =
      LookUp(GridRays(camera, {4, 1}, kPixelCenter), camera, map);
  EXPECT_EQ(cv::countNonZero(found), 1);
  EXPECT_EQ(found(0, 3), 2);
}

}  // namespace
}  // namespace structnerf
