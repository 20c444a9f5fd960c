#include "colmap_plugin/evaluation/map_agreement.h"

#include <gtest/gtest.h>

namespace structnerf {
namespace {

TEST(AgreementCounterTest, CountsEachViewAndAll) {
  AgreementCounter counter;
  const cv::Mat1f good(8, 16, 0.005f);
  cv::Mat1f poor(8, 16, 0.03f);
  poor.colRange(0, 8).setTo(-1);  // no value
  MapAgreement agreement = counter.Add(good);
  EXPECT_EQ(agreement.num_common, 128);
  EXPECT_EQ(agreement.shares, (std::array<double, 3>{1, 1, 1}));
  EXPECT_FLOAT_EQ(agreement.median_difference, 0.005f);
  agreement = counter.Add(poor);
  EXPECT_EQ(agreement.num_common, 64);
  EXPECT_EQ(agreement.shares, (std::array<double, 3>{0, 0, 1}));
  EXPECT_FLOAT_EQ(agreement.median_difference, 0.03f);
  const MapAgreement total = counter.Total();
  EXPECT_EQ(total.num_common, 192);
  EXPECT_DOUBLE_EQ(total.shares[0], 2.0 / 3);
  EXPECT_DOUBLE_EQ(total.shares[2], 1);
  EXPECT_FLOAT_EQ(total.median_difference, 0.005f);
}

TEST(AgreementCounterTest, NothingInCommonIsNoAgreement) {
  AgreementCounter counter;
  EXPECT_EQ(counter.Add(cv::Mat1f(2, 2, -1.0f)).num_common, 0);
  EXPECT_EQ(counter.Total().num_common, 0);
  EXPECT_EQ(counter.Total().shares[2], 0);
}

}  // namespace
}  // namespace structnerf
