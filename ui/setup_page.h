#pragma once

#include "colmap_plugin/run_expectation.h"
#include "colmap_plugin/structnerf_options.h"

#include <QCheckBox>
#include <QComboBox>
#include <QDoubleSpinBox>
#include <QLabel>
#include <QLineEdit>
#include <QPushButton>
#include <QWidget>
#include <functional>
#include <memory>

#include <colmap/scene/reconstruction.h>

class QFormLayout;

namespace structnerf {

// What a user has to say before a run, and what to expect of it.
class SetupPage : public QWidget {
 public:
  // `options` must outlive this object. `start` is called when the button is
  // pressed, with the options up to date.
  SetupPage(StructNerfOptions* options,
            std::function<void()> start,
            QWidget* parent);

  // Shows the options, and what a run on this model would be like.
  void ShowModel(std::shared_ptr<const colmap::Reconstruction> reconstruction);

  // Says anew what to expect.
  void UpdateExpectation();

  // Takes over what has been typed in.
  void WriteOptions();

 private:
  QLineEdit* AddFolder(const QString& label,
                       const char* name,
                       QFormLayout* form);
  QComboBox* AddChoice(const QString& label,
                       const char* name,
                       const QStringList& words,
                       QFormLayout* form);

  // Take the presets of the words that are chosen. Options that have been
  // changed since, or were given on the command line, stay.
  void ChangePresetTo(const ReconstructionOptions& preset);
  void ChangeWords();
  void ChangeTimeLimit(double minutes);

  StructNerfOptions* const options_;
  ReconstructionOptions preset_;     // what the method's options started from
  bool quality_is_of_time_ = false;  // chosen by the time limit
  std::unique_ptr<RunForecast> forecast_;
  QLineEdit* workspace_path_;
  QLineEdit* image_path_;
  QLineEdit* mask_path_;
  QComboBox* method_;
  QComboBox* quality_;
  QDoubleSpinBox* max_minutes_;
  QComboBox* device_;
  QCheckBox* overwrite_;
  QLabel* expectation_;
  QPushButton* start_button_;
};

}  // namespace structnerf
