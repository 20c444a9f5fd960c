#pragma once

#include "colmap_plugin/run_progress.h"

#include <QLabel>
#include <QWidget>
#include <array>

namespace structnerf {

// One view during training: photograph, rendered colour, depth and normals.
class PreviewWidget : public QWidget {
 public:
  explicit PreviewWidget(QWidget* parent);

  void SetPreview(const Preview& preview);
  void Clear();

 private:
  std::array<QLabel*, 4> pictures_;
};

}  // namespace structnerf
