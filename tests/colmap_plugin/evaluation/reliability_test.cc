#include "colmap_plugin/evaluation/reliability.h"

#include <gtest/gtest.h>

namespace structnerf {
namespace {

TEST(Reliability, ComparesPredictionAndOutcomeBinByBin) {
  Reliability reliability;
  for (int i = 0; i < 4; ++i) {
    reliability.Add(0.75, i < 3);  // as predicted
    reliability.Add(0.2, i < 2);   // half instead of a fifth
  }
  EXPECT_EQ(reliability.NumPixels(), 8);
  EXPECT_EQ(reliability.NumPixels(7), 4);
  EXPECT_DOUBLE_EQ(reliability.MeanPrediction(7), 0.75);
  EXPECT_DOUBLE_EQ(reliability.ShareRight(7), 0.75);
  EXPECT_EQ(reliability.NumPixels(2), 4);
  EXPECT_DOUBLE_EQ(reliability.MeanPrediction(2), 0.2);
  EXPECT_DOUBLE_EQ(reliability.ShareRight(2), 0.5);
  EXPECT_EQ(reliability.NumPixels(0), 0);
  EXPECT_DOUBLE_EQ(reliability.CalibrationError(), 0.15);
}

TEST(Reliability, TheLimitsHaveABin) {
  Reliability reliability;
  reliability.Add(0, false);
  reliability.Add(1, true);
  EXPECT_EQ(reliability.NumPixels(0), 1);
  EXPECT_EQ(reliability.NumPixels(Reliability::kNumBins - 1), 1);
  EXPECT_EQ(reliability.CalibrationError(), 0);
}

}  // namespace
}  // namespace structnerf
