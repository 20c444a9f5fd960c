#include "colmap_plugin/tradeoff/tradeoff_plot.h"

#include <algorithm>
#include <map>
#include <utility>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

namespace structnerf {
namespace {

const cv::Vec3b kFront(178, 114, 0);
const cv::Vec3b kOther(0, 94, 213);

int CountPixels(const cv::Mat3b& plot, const cv::Vec3b& color) {
  cv::Mat mask;
  cv::inRange(plot, color, color, mask);
  return cv::countNonZero(mask);
}

TEST(TradeoffPlot, ColoursTellTheFront) {
  const std::vector<TradeoffPoint> front = {{"low", 20, 0.4, 0.39, 0.41},
                                            {"high", 90, 0.3, 0.3, 0.3}};
  const cv::Mat3b plot = PlotTradeoff(front, "error, %");
  EXPECT_GT(CountPixels(plot, kFront), 500);  // dots and line
  EXPECT_EQ(CountPixels(plot, kOther), 0);

  std::vector<TradeoffPoint> more = front;
  more.push_back({"bad", 50, 0.5, 0.45, 0.55});
  const cv::Mat3b other_plot = PlotTradeoff(more, "error, %");
  EXPECT_GT(CountPixels(other_plot, kOther), 50);
  EXPECT_GT(CountPixels(other_plot, kFront), 200);
}

TEST(TradeoffPlot, OnePointAndEqualPointsCanBeDrawn) {
  for (const double error : {0.0, 0.5, 1.0}) {
    const TradeoffPoint point = {"only", 12, error, error, error};
    EXPECT_GT(CountPixels(PlotTradeoff({point}, "error"), kFront), 30);
    EXPECT_GT(CountPixels(PlotTradeoff({point, point}, "error"), kFront), 30);
  }
}

// Grey verticals, which cross the middle of the plot's height.
TEST(TradeoffPlot, TheTimeAxisHasTwoValuesAtLeast) {
  const cv::Vec3b grey(215, 215, 215);
  for (const auto& [first, last] :
       {std::pair(12.0, 12.0), {30.0, 33.0}, {0.3, 0.3}, {1.0, 5000.0}}) {
    const cv::Mat3b plot = PlotTradeoff(
        {{"a", first, 0.1, 0.1, 0.1}, {"b", last, 0.9, 0.9, 0.9}}, "error");
    std::map<int, int> grey_pixels;  // by column
    for (int row = 0; row < plot.rows; ++row) {
      for (int col = 0; col < plot.cols; ++col) {
        grey_pixels[col] += plot(row, col) == grey;
      }
    }
    const auto num_lines = std::count_if(
        grey_pixels.begin(), grey_pixels.end(), [&](const auto& column) {
          return column.second > plot.rows / 2;
        });
    EXPECT_GE(num_lines, 2) << first;
  }
}

}  // namespace
}  // namespace structnerf
