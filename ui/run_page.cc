#include "ui/run_page.h"

#include "colmap_plugin/text_output.h"

#include <QGridLayout>
#include <QHBoxLayout>
#include <QVBoxLayout>
#include <utility>

namespace structnerf {
namespace {

constexpr int kBarMaximum = 1000;

}  // namespace

RunPage::RunPage(std::function<void()> cancel, QWidget* parent)
    : QWidget(parent) {
  auto* layout = new QVBoxLayout(this);

  auto* line = new QHBoxLayout();
  stage_ = new QLabel(this);
  stage_->setObjectName("stage");
  line->addWidget(stage_, 1);
  time_left_ = new QLabel(this);
  time_left_->setObjectName("time_left");
  line->addWidget(time_left_);
  layout->addLayout(line);

  bar_ = new QProgressBar(this);
  bar_->setObjectName("bar");
  bar_->setMaximum(kBarMaximum);
  layout->addWidget(bar_);

  auto* middle = new QHBoxLayout();
  layout->addLayout(middle, 1);
  auto* curves = new QVBoxLayout();
  middle->addLayout(curves, 1);
  loss_ = new CurveWidget("Loss", QColor(180, 60, 40), 4, this);
  loss_->setObjectName("loss");
  curves->addWidget(loss_, 1);
  psnr_ = new CurveWidget("Held-out PSNR in dB", QColor(40, 90, 170), 1, this);
  psnr_->setObjectName("psnr");
  curves->addWidget(psnr_, 1);
  auto* watch = new QVBoxLayout();
  middle->addLayout(watch);
  image_ = new QComboBox(this);
  image_->setObjectName("image");
  image_->setToolTip("View that is watched while it is trained");
  connect(image_,
          static_cast<void (QComboBox::*)(int)>(&QComboBox::activated),
          this,
          [this](const int index) {
            if (progress_ != nullptr) {
              progress_->WatchImage(image_->itemText(index).toStdString());
            }
          });
  watch->addWidget(image_);
  preview_ = new PreviewWidget(this);
  watch->addWidget(preview_);
  watch->addStretch(1);

  auto* buttons = new QHBoxLayout();
  layout->addLayout(buttons);
  buttons->addStretch(1);
  pause_button_ = new QPushButton("Pause", this);
  pause_button_->setObjectName("pause");
  connect(
      pause_button_, &QPushButton::clicked, this, [this]() { TogglePause(); });
  buttons->addWidget(pause_button_);
  stop_button_ = new QPushButton("Stop and keep", this);
  stop_button_->setObjectName("stop");
  stop_button_->setToolTip(
      "End training now and make maps from what has been learned");
  connect(stop_button_, &QPushButton::clicked, this, [this]() {
    progress_->Stop();
    ShowState();
  });
  buttons->addWidget(stop_button_);
  cancel_button_ = new QPushButton("Cancel", this);
  cancel_button_->setObjectName("cancel");
  cancel_button_->setToolTip("End now and write no maps");
  connect(cancel_button_, &QPushButton::clicked, this, std::move(cancel));
  buttons->addWidget(cancel_button_);
  ShowEnd();
}

void RunPage::ShowBegin(const std::vector<std::string>& image_names,
                        GuiProgress* progress) {
  progress_ = progress;
  image_->clear();
  for (const std::string& name : image_names) {
    image_->addItem(QString::fromStdString(name));
  }
  progress_->WatchImage(image_->currentText().toStdString());
  preview_->Clear();
  ShowState();
}

void RunPage::ShowState() {
  const RunState state = progress_->State();
  // Views are matched between two rounds of it.
  const bool is_training =
      state.stage == "Training" || state.stage == "Matching views";
  QString stage = QString::fromStdString(state.stage);
  if (state.is_paused) {
    stage += " (paused)";
  } else if (state.is_stopping) {
    stage += " (ending)";
  }
  stage_->setText(stage);
  bar_->setValue(static_cast<int>(kBarMaximum * state.fraction));
  time_left_->setText(
      state.seconds_left < 0 || state.fraction >= 1
          ? QString()
          : QString::fromStdString(DurationText(state.seconds_left)) + " left");
  pause_button_->setText(state.is_paused ? "Resume" : "Pause");
  pause_button_->setEnabled(!state.is_stopping);
  stop_button_->setEnabled(is_training && !state.is_stopping);
  cancel_button_->setEnabled(true);
  loss_->SetCurve(state.loss);
  psnr_->SetCurve(state.held_out_psnr);
  if (state.preview != nullptr && state.preview != shown_preview_) {
    preview_->SetPreview(*state.preview);
    shown_preview_ = state.preview;
  }
}

void RunPage::ShowEnd() {
  progress_ = nullptr;
  shown_preview_.reset();
  time_left_->clear();
  for (QPushButton* button : {pause_button_, stop_button_, cancel_button_}) {
    button->setEnabled(false);
  }
}

void RunPage::TogglePause() {
  progress_->SetPaused(!progress_->State().is_paused);
  ShowState();
}

}  // namespace structnerf
