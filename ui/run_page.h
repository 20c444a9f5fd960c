#pragma once

#include "ui/curve_widget.h"
#include "ui/gui_progress.h"
#include "ui/preview_widget.h"

#include <QComboBox>
#include <QLabel>
#include <QProgressBar>
#include <QPushButton>
#include <QWidget>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace structnerf {

// A run while it lasts: where it is, how it learns, what one view looks like,
// and the buttons to pause and to end it.
class RunPage : public QWidget {
 public:
  // `cancel` is called when the user wants the run to end.
  RunPage(std::function<void()> cancel, QWidget* parent);

  // `progress` is used until ShowEnd() is called.
  void ShowBegin(const std::vector<std::string>& image_names,
                 GuiProgress* progress);

  // To be called several times a second.
  void ShowState();

  void ShowEnd();

 private:
  void TogglePause();

  GuiProgress* progress_ = nullptr;
  std::shared_ptr<const Preview> shown_preview_;
  QLabel* stage_;
  QLabel* time_left_;
  QProgressBar* bar_;
  QPushButton* pause_button_;
  QPushButton* stop_button_;
  QPushButton* cancel_button_;
  QComboBox* image_;
  CurveWidget* loss_;
  CurveWidget* psnr_;
  PreviewWidget* preview_;
};

}  // namespace structnerf
