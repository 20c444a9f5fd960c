#include "tests/support/numeric_gradient.h"

#include <gtest/gtest.h>

namespace structnerf {
namespace {

TEST(NumericGradient, MatchesTheDerivative) {
  const auto function = [](const std::vector<double>& x) {
    return x[0] * x[0] * x[1] + std::sin(x[2]);
  };
  const std::vector<double> gradient = NumericGradient(function, {3, 2000, 1});
  ASSERT_EQ(gradient.size(), 3);
  EXPECT_NEAR(gradient[0], 12000, 1e-3);
  EXPECT_NEAR(gradient[1], 9, 1e-5);
  EXPECT_NEAR(gradient[2], std::cos(1.0), 1e-5);
}

}  // namespace
}  // namespace structnerf
