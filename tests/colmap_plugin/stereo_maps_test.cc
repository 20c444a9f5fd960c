#include "colmap_plugin/stereo_maps.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace structnerf {
namespace {

using testing::ElementsAre;

TEST(StereoMaps, KeepsDepthAndNormalTogether) {
  StereoMaps maps{2, 2, {1, 2, 0, 4}, {}};
  for (int i = 0; i < 12; ++i) {
    maps.normal.push_back(1.0f + i);
  }
  EXPECT_EQ(maps.NumDepths(), 3);
  maps.KeepOnly({255, 0, 1, 0});
  EXPECT_THAT(maps.depth, ElementsAre(1, 0, 0, 0));
  EXPECT_THAT(maps.normal, ElementsAre(1, 0, 3, 0, 5, 0, 7, 0, 9, 0, 11, 0));
  EXPECT_EQ(maps.NumDepths(), 1);
}

}  // namespace
}  // namespace structnerf
