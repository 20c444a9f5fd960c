#include "ui/map_viewer.h"

#include "ui/map_images.h"

#include <QMouseEvent>
#include <QPixmap>
#include <QWheelEvent>
#include <cmath>
#include <stdexcept>
#include <utility>

#include <colmap/ui/qt_utils.h>

namespace structnerf {

MapViewer::MapViewer(QWidget* parent) : ImageViewerWidget(parent) {
  resize(720, 600);
  view_ = findChild<QGraphicsView*>();
  view_->setDragMode(QGraphicsView::ScrollHandDrag);
  view_->viewport()->setMouseTracking(true);
  view_->viewport()->installEventFilter(this);
  value_ = new QLabel(this);
  value_->setObjectName("value");
  grid_layout_->addWidget(value_, 2, 0, Qt::AlignLeft);
}

void MapViewer::ShowMap(const QString& title,
                        const Kind kind,
                        StereoMaps maps) {
  kind_ = kind;
  maps_ = std::move(maps);
  setWindowTitle(title);
  value_->clear();
  ShowPixmap(QPixmap::fromImage(
      kind == Kind::kNormal
          ? ImageFromNormal(maps_.width, maps_.height, maps_.normal)
          : ImageFromDepth(maps_.width, maps_.height, maps_.depth)));
}

void MapViewer::ShowPhotograph(const QString& title, const QString& path) {
  maps_ = StereoMaps();
  setWindowTitle(title);
  value_->clear();
  colmap::Bitmap bitmap;
  if (!bitmap.Read(path.toStdString())) {
    throw std::runtime_error("The photograph " + path.toStdString() +
                             " cannot be read.");
  }
  ShowPixmap(QPixmap::fromImage(colmap::BitmapToQImageRGB(bitmap)));
}

QString MapViewer::ValueText(const int col, const int row) const {
  if (col < 0 || col >= maps_.width || row < 0 || row >= maps_.height) {
    return "";
  }
  const size_t num_pixels = maps_.depth.size();
  const size_t index = static_cast<size_t>(row) * maps_.width + col;
  const QString place = QString("(%1, %2): ").arg(col).arg(row);
  if (!(maps_.depth[index] > 0)) {
    return place + "no value";
  }
  if (kind_ == Kind::kDepth) {
    return place + QString("depth %1").arg(maps_.depth[index]);
  }
  if (kind_ == Kind::kConfidence) {
    return place + QString("confidence %1").arg(maps_.depth[index], 0, 'f', 2);
  }
  return place + QString("normal (%1, %2, %3)")
                     .arg(maps_.normal[index], 0, 'f', 3)
                     .arg(maps_.normal[num_pixels + index], 0, 'f', 3)
                     .arg(maps_.normal[2 * num_pixels + index], 0, 'f', 3);
}

bool MapViewer::eventFilter(QObject* object, QEvent* event) {
  if (event->type() == QEvent::MouseMove) {
    const QPointF point =
        view_->mapToScene(static_cast<QMouseEvent*>(event)->pos());
    value_->setText(ValueText(static_cast<int>(std::floor(point.x())),
                              static_cast<int>(std::floor(point.y()))));
  } else if (event->type() == QEvent::Wheel) {
    if (static_cast<QWheelEvent*>(event)->angleDelta().y() > 0) {
      ZoomIn();
    } else {
      ZoomOut();
    }
    return true;
  }
  return ImageViewerWidget::eventFilter(object, event);
}

}  // namespace structnerf
