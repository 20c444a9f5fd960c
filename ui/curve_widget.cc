#include "ui/curve_widget.h"

#include <QPainter>
#include <QPolygonF>
#include <algorithm>
#include <utility>

namespace structnerf {

CurveWidget::CurveWidget(const QString& title,
                         const QColor& color,
                         const int num_decimals,
                         QWidget* parent)
    : QWidget(parent),
      title_(title),
      color_(color),
      num_decimals_(num_decimals) {
  setMinimumSize(160, 80);
}

void CurveWidget::SetCurve(std::vector<CurvePoint> curve) {
  curve_ = std::move(curve);
  update();
}

void CurveWidget::paintEvent(QPaintEvent*) {
  QPainter painter(this);
  painter.setRenderHint(QPainter::Antialiasing);
  const int line_height = painter.fontMetrics().height();
  const QRectF frame(
      0.5, line_height + 0.5, width() - 1, height() - 1 - line_height);
  painter.fillRect(frame, palette().base());
  painter.setPen(palette().color(QPalette::Mid));
  painter.drawRect(frame);
  painter.setPen(palette().color(QPalette::WindowText));
  QString title = title_;
  if (!curve_.empty()) {
    title += ": " + QString::number(curve_.back().value, 'f', num_decimals_);
  }
  painter.drawText(0, painter.fontMetrics().ascent(), title);
  if (curve_.empty()) {
    return;
  }

  const auto [lowest, highest] =
      std::minmax_element(curve_.begin(),
                          curve_.end(),
                          [](const CurvePoint& a, const CurvePoint& b) {
                            return a.value < b.value;
                          });
  const double margin = 0.05 * frame.height();
  const double range = std::max(highest->value - lowest->value, 1e-9);
  QPolygonF line;
  for (const CurvePoint& point : curve_) {
    line << QPointF(frame.left() + point.fraction * frame.width(),
                    frame.bottom() - margin -
                        (point.value - lowest->value) / range *
                            (frame.height() - 2 * margin));
  }
  painter.setPen(QPen(color_, 1.5));
  painter.drawPolyline(line);
  painter.setBrush(color_);
  painter.drawEllipse(line.back(), 2.5, 2.5);

  painter.setPen(palette().color(QPalette::PlaceholderText));
  const QRectF labels = frame.adjusted(3, 1, -3, -1);
  painter.drawText(labels,
                   Qt::AlignLeft | Qt::AlignTop,
                   QString::number(highest->value, 'f', num_decimals_));
  painter.drawText(labels,
                   Qt::AlignLeft | Qt::AlignBottom,
                   QString::number(lowest->value, 'f', num_decimals_));
}

}  // namespace structnerf
