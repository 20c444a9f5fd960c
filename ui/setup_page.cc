#include "ui/setup_page.h"

#include "colmap_plugin/option_table.h"
#include "colmap_plugin/quality_choice.h"
#include "nerf/method_options.h"
#include "ui/folder_edit.h"

#include <QFormLayout>
#include <QHBoxLayout>
#include <QVBoxLayout>
#include <utility>

namespace structnerf {

SetupPage::SetupPage(StructNerfOptions* options,
                     std::function<void()> start,
                     QWidget* parent)
    : QWidget(parent),
      options_(options),
      preset_(MakePreset(options->method, options->quality)) {
  auto* layout = new QVBoxLayout(this);
  auto* form = new QFormLayout();
  layout->addLayout(form);
  workspace_path_ = AddFolder("Workspace", "workspace_path", form);
  workspace_path_->setToolTip(
      "Folder of the new dense workspace, in COLMAP's layout");
  image_path_ = AddFolder("Images", "image_path", form);
  image_path_->setToolTip("Folder with the original images of the model");
  mask_path_ = AddFolder("Masks (optional)", "mask_path", form);
  mask_path_->setToolTip("Folder with <image name>.png, black = ignore");

  quality_ = AddChoice(
      "Quality", "quality", {"low", "medium", "high", "extreme"}, form);
  method_ = AddChoice(
      "Method",
      "method",
      {"structnerf", "nerf", "dsnerf", "dense_depth_prior", "nerfing_mvs"},
      form);
  method_->setToolTip("This one, or those that the paper compares it with");
  for (QComboBox* const choice : {quality_, method_}) {
    connect(choice,
            static_cast<void (QComboBox::*)(int)>(&QComboBox::activated),
            this,
            [this](int) { ChangeWords(); });
  }

  max_minutes_ = new QDoubleSpinBox(this);
  max_minutes_->setObjectName("max_minutes");
  max_minutes_->setRange(0, 1e6);
  max_minutes_->setDecimals(2);
  max_minutes_->setSuffix(" min");
  max_minutes_->setSpecialValueText("none");
  max_minutes_->setKeyboardTracking(false);
  max_minutes_->setToolTip(
      "Chooses the best quality that fits, and shortens its training");
  connect(max_minutes_,
          static_cast<void (QDoubleSpinBox::*)(double)>(
              &QDoubleSpinBox::valueChanged),
          this,
          [this](const double minutes) { ChangeTimeLimit(minutes); });
  form->addRow("Time limit", max_minutes_);

  device_ = AddChoice("Device", "device", {"cpu", "cuda", "auto"}, form);
  device_->setToolTip(
      "Processor or NVIDIA card; auto = a card if there is one");

  overwrite_ = new QCheckBox("Replace dense results in the workspace", this);
  overwrite_->setObjectName("overwrite");
  form->addRow("", overwrite_);

  expectation_ = new QLabel(this);
  expectation_->setObjectName("expectation");
  expectation_->setWordWrap(true);
  expectation_->setFrameShape(QFrame::StyledPanel);
  expectation_->setMargin(6);
  layout->addWidget(expectation_);
  layout->addStretch(1);

  start_button_ = new QPushButton("Start", this);
  start_button_->setObjectName("start");
  connect(start_button_,
          &QPushButton::clicked,
          this,
          [this, start = std::move(start)]() {
            WriteOptions();
            start();
          });
  layout->addWidget(start_button_, 0, Qt::AlignRight);
}

QLineEdit* SetupPage::AddFolder(const QString& label,
                                const char* name,
                                QFormLayout* form) {
  auto* row = new QHBoxLayout();
  QLineEdit* path = AddFolderEdit(name, this, row);
  form->addRow(label, row);
  return path;
}

QComboBox* SetupPage::AddChoice(const QString& label,
                                const char* name,
                                const QStringList& words,
                                QFormLayout* form) {
  auto* choice = new QComboBox(this);
  choice->setObjectName(name);
  choice->addItems(words);
  form->addRow(label, choice);
  return choice;
}

void SetupPage::ShowModel(
    std::shared_ptr<const colmap::Reconstruction> reconstruction) {
  forecast_ = std::make_unique<RunForecast>(std::move(reconstruction));
  workspace_path_->setText(QString::fromStdString(options_->output_path));
  image_path_->setText(QString::fromStdString(options_->image_path));
  mask_path_->setText(QString::fromStdString(options_->mask_path));
  const QString quality = QString::fromStdString(options_->quality);
  if (quality_->findText(quality) < 0) {
    quality_->addItem(quality);  // a preset for the few
  }
  quality_->setCurrentText(quality);
  method_->setCurrentText(QString::fromStdString(options_->method));
  const QSignalBlocker blocker(max_minutes_);
  max_minutes_->setValue(options_->max_minutes);
  device_->setCurrentText(QString::fromStdString(options_->device));
  overwrite_->setChecked(options_->overwrite);
  if (quality_is_of_time_) {
    ChangeTimeLimit(options_->max_minutes);  // another model, another time
  } else {
    UpdateExpectation();
  }
}

void SetupPage::UpdateExpectation() {
  const RunExpectation expectation = forecast_->Expect(*options_);
  expectation_->setText(QString::fromStdString(expectation.text));
  start_button_->setEnabled(expectation.is_possible);
}

void SetupPage::ChangePresetTo(const ReconstructionOptions& preset) {
  options_->reconstruction =
      ChangePreset(options_->reconstruction, preset_, preset);
  preset_ = preset;
  UpdateExpectation();
}

void SetupPage::ChangeWords() {
  options_->quality = quality_->currentText().toStdString();
  options_->method = method_->currentText().toStdString();
  quality_is_of_time_ = false;
  ChangePresetTo(MakePreset(options_->method, options_->quality));
}

void SetupPage::ChangeTimeLimit(const double minutes) {
  options_->max_minutes = minutes;
  quality_is_of_time_ = minutes > 0;
  if (quality_is_of_time_) {
    const QualityChoice choice = ChooseQuality(*options_, forecast_->Cameras());
    options_->quality = choice.quality;
    quality_->setCurrentText(QString::fromStdString(choice.quality));
    ReconstructionOptions preset =
        MakePreset(options_->method, options_->quality);
    preset.stereo.num_iterations = choice.num_sweeps;
    ChangePresetTo(preset);
  } else {
    // With all of its sweeps.
    ChangePresetTo(MakePreset(options_->method, options_->quality));
  }
}

void SetupPage::WriteOptions() {
  options_->output_path = workspace_path_->text().toStdString();
  options_->image_path = image_path_->text().toStdString();
  options_->mask_path = mask_path_->text().toStdString();
  options_->device = device_->currentText().toStdString();
  options_->overwrite = overwrite_->isChecked();
}

}  // namespace structnerf
