#include "nerf/pixel_transfer.h"

#include "tests/nerf/plane_scene.h"

#include <utility>

#include <gtest/gtest.h>

namespace structnerf {
namespace {

// Far from the world's origin, as in geo-referenced models.
const Eigen::Vector3d kOrigin(4e5, -5e6, 300);

const View kFrom = MakeView("from", {64, 48, 70, 66, 30, 25.5}, kOrigin);
const View kTo = MakeView("to",
                          {80, 60, 90, 95, 41, 28},
                          kOrigin + Eigen::Vector3d(0.5, -0.2, 0.3),
                          Eigen::Vector3d(-0.2, 0.1, 1));

TEST(PixelTransfer, ProjectsIntoTheOtherView) {
  const PixelTransfer transfer(kFrom, kFrom.camera, kTo, kTo.camera);
  for (const double depth : {0.9, 4.0, 30.0}) {
    for (const auto& [x, y] :
         {std::pair(0.5, 0.5), {63.5, 7.0}, {20.0, 47.5}}) {
      Eigen::Vector3d result;
      ASSERT_TRUE(transfer.Apply(x, y, depth, &result));
      const Eigen::Vector3d expected =
          Project(kTo, Unproject(kFrom, x, y, depth));
      // World coordinates of this size are exact to 1e-9.
      EXPECT_LT((result - expected).norm(), 1e-6) << x << " " << y;
      EXPECT_NEAR(transfer.Depth(x, y, depth), result.z(), 1e-12);
    }
  }
}

TEST(PixelTransfer, IsMeantAtTheSizesOfTheCameras) {
  const PixelTransfer whole(kFrom, kFrom.camera, kTo, kTo.camera);
  const PixelTransfer reduced(
      kFrom, kFrom.camera.Resized(32, 24), kTo, kTo.camera.Resized(20, 15));
  Eigen::Vector3d expected;
  ASSERT_TRUE(whole.Apply(20, 30, 4, &expected));
  Eigen::Vector3d result;
  ASSERT_TRUE(reduced.Apply(10, 15, 4, &result));
  EXPECT_NEAR(result.x(), expected.x() / 4, 1e-9);
  EXPECT_NEAR(result.y(), expected.y() / 4, 1e-9);
  EXPECT_NEAR(result.z(), expected.z(), 1e-9);
}

TEST(PixelTransfer, RefusesWhatIsNotInFrontOfTheCamera) {
  const View opposite =
      MakeView("opposite", kTo.camera, kOrigin, Eigen::Vector3d(0, 0, -1));
  const PixelTransfer transfer(kFrom, kFrom.camera, opposite, opposite.camera);
  Eigen::Vector3d result(7, 7, 7);
  EXPECT_FALSE(transfer.Apply(20, 30, 4, &result));
  EXPECT_EQ(result, Eigen::Vector3d(7, 7, 7));
  EXPECT_LE(transfer.Depth(20, 30, 4), 0);
}

}  // namespace
}  // namespace structnerf
