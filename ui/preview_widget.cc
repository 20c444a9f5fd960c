#include "ui/preview_widget.h"

#include "ui/map_images.h"

#include <QGridLayout>
#include <QPixmap>

namespace structnerf {
namespace {

constexpr int kPictureWidth = 240;
constexpr int kPictureHeight = 180;

}  // namespace

PreviewWidget::PreviewWidget(QWidget* parent) : QWidget(parent) {
  auto* grid = new QGridLayout(this);
  grid->setContentsMargins(0, 0, 0, 0);
  const std::array<const char*, 4> titles = {
      "Photograph", "Rendered", "Depth", "Normals"};
  for (int i = 0; i < 4; ++i) {
    grid->addWidget(new QLabel(titles[i], this), i / 2 * 2, i % 2);
    pictures_[i] = new QLabel(this);
    pictures_[i]->setObjectName(titles[i]);
    pictures_[i]->setFixedSize(kPictureWidth, kPictureHeight);
    pictures_[i]->setAlignment(Qt::AlignCenter);
    pictures_[i]->setFrameShape(QFrame::StyledPanel);
    grid->addWidget(pictures_[i], i / 2 * 2 + 1, i % 2);
  }
}

void PreviewWidget::SetPreview(const Preview& preview) {
  const std::array<QImage, 4> images = {
      ImageFromRgb(preview.width, preview.height, preview.photograph),
      ImageFromRgb(preview.width, preview.height, preview.color),
      ImageFromDepth(preview.width, preview.height, preview.depth),
      ImageFromNormal(preview.width, preview.height, preview.normal)};
  for (int i = 0; i < 4; ++i) {
    pictures_[i]->setPixmap(
        QPixmap::fromImage(images[i].scaled(kPictureWidth,
                                            kPictureHeight,
                                            Qt::KeepAspectRatio,
                                            Qt::SmoothTransformation)));
  }
}

void PreviewWidget::Clear() {
  for (QLabel* picture : pictures_) {
    picture->clear();
  }
}

}  // namespace structnerf
