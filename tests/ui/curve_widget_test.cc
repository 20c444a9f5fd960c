#include "ui/curve_widget.h"

#include <QImage>

#include <gtest/gtest.h>

namespace structnerf {
namespace {

// Row of the curve's pixels in a column; -1 if there is none.
int CurveRow(const QImage& image, const int col) {
  for (int row = 0; row < image.height(); ++row) {
    const QColor color = image.pixelColor(col, row);
    if (color.red() > 200 && color.green() < 80 && color.blue() < 80) {
      return row;
    }
  }
  return -1;
}

TEST(CurveWidget, DrawsTheCourseOfTheValue) {
  CurveWidget widget("Loss", QColor(255, 0, 0), 2, nullptr);
  widget.resize(300, 200);
  EXPECT_EQ(CurveRow(widget.grab().toImage(), 75), -1);
  widget.SetCurve({{0, 4}, {0.5, 2}, {0.75, 3}});
  const QImage image = widget.grab().toImage();
  const int falling = CurveRow(image, 75);
  const int lowest = CurveRow(image, 149);
  const int rising = CurveRow(image, 210);
  ASSERT_GT(falling, 0);
  EXPECT_GT(lowest, falling + 20);
  EXPECT_LT(rising, lowest - 20);
  EXPECT_EQ(CurveRow(image, 280), -1);
}

TEST(CurveWidget, OneValueIsEnough) {
  CurveWidget widget("Loss", QColor(255, 0, 0), 2, nullptr);
  widget.resize(300, 200);
  widget.SetCurve({{0.5, 1}});
  EXPECT_GT(CurveRow(widget.grab().toImage(), 150), 0);
}

}  // namespace
}  // namespace structnerf
