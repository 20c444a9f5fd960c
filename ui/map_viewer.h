#pragma once

#include "colmap_plugin/stereo_maps.h"

#include <QGraphicsView>
#include <QLabel>
#include <QString>

#include <colmap/ui/image_viewer_widget.h>

namespace structnerf {

// COLMAP's image viewer with one of a view's maps in it: the wheel zooms, and
// the value under the cursor is written below.
class MapViewer : public colmap::ImageViewerWidget {
 public:
  enum class Kind { kDepth, kNormal, kConfidence };

  explicit MapViewer(QWidget* parent);

  // Whatever was shown before is replaced. Confidence comes in place of depth.
  void ShowMap(const QString& title, Kind kind, StereoMaps maps);
  void ShowPhotograph(const QString& title, const QString& path);

  // What is written when the cursor is at a pixel; empty outside of the map.
  QString ValueText(int col, int row) const;

 protected:
  bool eventFilter(QObject* object, QEvent* event) override;

 private:
  QGraphicsView* view_;
  QLabel* value_;
  Kind kind_ = Kind::kDepth;
  StereoMaps maps_;
};

}  // namespace structnerf
