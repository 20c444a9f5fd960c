#include "nerf/extract/map_resolution.h"

#include "tests/nerf/plane_scene.h"

#include <gtest/gtest.h>

namespace structnerf {
namespace {

TEST(PixelsPerReferencePixel, IsThatOfTheLongerSideAndAtLeastOne) {
  EXPECT_EQ(PixelsPerReferencePixel(MakeCamera(640, 480, 500)), 1);
  EXPECT_EQ(PixelsPerReferencePixel(MakeCamera(320, 240, 500)), 1);
  EXPECT_EQ(PixelsPerReferencePixel(MakeCamera(1600, 1200, 500)), 2.5);
  EXPECT_EQ(PixelsPerReferencePixel(MakeCamera(480, 1280, 500)), 2);
}

TEST(WholePixelsPerReferencePixel, AreTheNearest) {
  EXPECT_EQ(WholePixelsPerReferencePixel(MakeCamera(320, 240, 500)), 1);
  EXPECT_EQ(WholePixelsPerReferencePixel(MakeCamera(959, 700, 500)), 1);
  EXPECT_EQ(WholePixelsPerReferencePixel(MakeCamera(960, 700, 500)), 2);
  EXPECT_EQ(WholePixelsPerReferencePixel(MakeCamera(1600, 1200, 500)), 3);
}

}  // namespace
}  // namespace structnerf
