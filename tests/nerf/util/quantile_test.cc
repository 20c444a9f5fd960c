#include "nerf/util/quantile.h"

#include <gtest/gtest.h>

namespace structnerf {
namespace {

TEST(Quantile, IsTheLowerOfTwoValues) {
  std::vector<float> values = {5, 1, 4, 2, 3};
  EXPECT_EQ(Quantile(&values, 0), 1);
  EXPECT_EQ(Quantile(&values, 0.5), 3);
  EXPECT_EQ(Quantile(&values, 0.74), 3);
  EXPECT_EQ(Quantile(&values, 0.75), 4);
  EXPECT_EQ(Quantile(&values, 1), 5);
}

TEST(Quantile, OfASingleValue) {
  std::vector<double> values = {7};
  for (const double share : {0.0, 0.3, 1.0}) {
    EXPECT_EQ(Quantile(&values, share), 7);
  }
}

}  // namespace
}  // namespace structnerf
