#include "colmap_plugin/text_output.h"

#include <gtest/gtest.h>

namespace structnerf {
namespace {

TEST(DurationText, IsShort) {
  EXPECT_EQ(DurationText(-1), "0 s");
  EXPECT_EQ(DurationText(59.4), "59 s");
  EXPECT_EQ(DurationText(59.6), "1:00 min");
  EXPECT_EQ(DurationText(187), "3:07 min");
  EXPECT_EQ(DurationText(3723), "1:02:03 h");
}

}  // namespace
}  // namespace structnerf
