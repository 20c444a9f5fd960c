#include "ui/dense_action.h"

#include <QIcon>
#include <QKeySequence>
#include <QPainter>
#include <QPixmap>
#include <QTimer>
#include <QToolBar>

namespace structnerf {
namespace {

constexpr int kUpdateMilliseconds = 200;
constexpr size_t kMinNumImages = 2;

// COLMAP's own icon of a dense reconstruction with a mark of ours.
QIcon MakeIcon(const QIcon& dense_icon) {
  QPixmap pixmap = dense_icon.pixmap(64, 64);
  if (pixmap.isNull()) {
    return dense_icon;
  }
  QPainter painter(&pixmap);
  painter.setRenderHint(QPainter::Antialiasing);
  const double size = pixmap.width() / pixmap.devicePixelRatio();
  painter.setPen(Qt::NoPen);
  painter.setBrush(QColor(220, 90, 30));
  painter.drawEllipse(
      QRectF(0.55 * size, 0.55 * size, 0.42 * size, 0.42 * size));
  return QIcon(pixmap);
}

}  // namespace

DenseAction::DenseAction(QMainWindow* window,
                         const MainWindowHook& hook,
                         StructNerfOptions* options,
                         ColmapLink* link)
    : QAction(MakeIcon(hook.dense_action->icon()),
              "StructNeRF dense reconstruction",
              window),
      link_(link),
      widget_(new DenseWidget(window, options, link)) {
  setObjectName("structnerf_dense");
  setShortcut(QKeySequence(Qt::CTRL | Qt::Key_D));
  connect(this, &QAction::triggered, widget_, [this]() { widget_->Show(); });
  hook.reconstruction_menu->addAction(this);
  for (QToolBar* tool_bar : window->findChildren<QToolBar*>()) {
    if (tool_bar->actions().contains(hook.dense_action)) {
      tool_bar->addAction(this);
    }
  }
  auto* timer = new QTimer(this);
  connect(timer, &QTimer::timeout, this, [this]() { UpdateEnabled(); });
  timer->start(kUpdateMilliseconds);
  UpdateEnabled();
}

void DenseAction::UpdateEnabled() {
  link_->Update();
  if (widget_->IsRunning()) {
    setEnabled(true);  // shows how far it is
    return;
  }
  if (link_->IsMapping()) {
    setEnabled(false);
    return;
  }
  const auto model = link_->Model();
  setEnabled(model != nullptr && model->NumRegImages() >= kMinNumImages);
}

}  // namespace structnerf
