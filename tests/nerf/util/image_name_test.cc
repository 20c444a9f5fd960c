#include "nerf/util/image_name.h"

#include <gtest/gtest.h>

namespace structnerf {
namespace {

TEST(ImageName, MustStayBelowTheFolder) {
  for (const char* name : {"a.jpg", "left/a.jpg", "a b.jpg", "..a", "ä.png"}) {
    EXPECT_TRUE(IsSafeImageName(name)) << name;
  }
  for (const char* name : {"",
                           "/a.jpg",
                           "../a.jpg",
                           "a/../../b.jpg",
                           "..",
                           "left/",
                           "a\tb.jpg",
                           "a\nb.jpg"}) {
    EXPECT_FALSE(IsSafeImageName(name)) << name;
  }
}

TEST(ImageName, IsShownOnOneLine) {
  EXPECT_EQ(Printable("a\nb\x7f ä"), "a?b? ä");
}

}  // namespace
}  // namespace structnerf
