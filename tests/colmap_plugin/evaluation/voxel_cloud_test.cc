#include "colmap_plugin/evaluation/voxel_cloud.h"

#include <limits>

#include <gtest/gtest.h>

namespace structnerf {
namespace {

TEST(VoxelCloudTest, KeepsTheMeanOfEachVoxel) {
  VoxelCloud cloud(0.1);
  EXPECT_TRUE(cloud.Add({1.01, 2.01, -3.01}));
  EXPECT_TRUE(cloud.Add({1.03, 2.03, -3.03}));
  EXPECT_TRUE(cloud.Add({1.21, 2.01, -3.01}));
  const auto points = cloud.Points();
  ASSERT_EQ(points.size(), 2);
  EXPECT_TRUE(points[0].isApprox(Eigen::Vector3d(1.02, 2.02, -3.02), 1e-12));
  EXPECT_TRUE(points[1].isApprox(Eigen::Vector3d(1.21, 2.01, -3.01), 1e-12));
}

TEST(VoxelCloudTest, NeighboursOnEitherSideOfZeroAreApart) {
  VoxelCloud cloud(1);
  cloud.Add({-0.9, 0, 0});
  cloud.Add({0.1, 0, 0});
  cloud.Add({0, -0.9, 0});
  EXPECT_EQ(cloud.Points().size(), 3);
}

TEST(VoxelCloudTest, LeavesOutWhatHasNoVoxel) {
  VoxelCloud cloud(0.01);
  EXPECT_FALSE(cloud.Add({std::numeric_limits<double>::quiet_NaN(), 0, 0}));
  EXPECT_FALSE(cloud.Add({1e9, 0, 0}));
  EXPECT_TRUE(cloud.Points().empty());
}

}  // namespace
}  // namespace structnerf
