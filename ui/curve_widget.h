#pragma once

#include "ui/gui_progress.h"

#include <QColor>
#include <QString>
#include <QWidget>
#include <vector>

namespace structnerf {

// A measurement over the course of the training, with its latest value.
class CurveWidget : public QWidget {
 public:
  // `num_decimals` of the values that are written.
  CurveWidget(const QString& title,
              const QColor& color,
              int num_decimals,
              QWidget* parent);

  void SetCurve(std::vector<CurvePoint> curve);
  const std::vector<CurvePoint>& Curve() const { return curve_; }

  QSize sizeHint() const override { return {240, 110}; }

 protected:
  void paintEvent(QPaintEvent* event) override;

 private:
  const QString title_;
  const QColor color_;
  const int num_decimals_;
  std::vector<CurvePoint> curve_;
};

}  // namespace structnerf
