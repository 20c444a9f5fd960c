#include "ui/comparison_bar.h"

#include "ui/error_dialog.h"
#include "ui/folder_edit.h"

#include <QDesktopServices>
#include <QHBoxLayout>
#include <QUrl>
#include <filesystem>
#include <set>
#include <system_error>

namespace structnerf {

namespace fs = std::filesystem;

ComparisonBar::ComparisonBar(QWidget* parent) : QWidget(parent) {
  auto* row = new QHBoxLayout(this);
  row->setContentsMargins(0, 0, 0, 0);
  row->addWidget(new QLabel("Compare with", this));
  other_path_ = AddFolderEdit("other_path", this, row);
  other_path_->setToolTip(
      "Another dense workspace of these images, for instance PatchMatch's");
  compare_button_ = new QPushButton("Compare", this);
  compare_button_->setObjectName("compare");
  connect(compare_button_, &QPushButton::clicked, this, [this]() {
    StartOrCancel();
  });
  row->addWidget(compare_button_);
  state_ = new QLabel(this);
  row->addWidget(state_);
  timer_ = new QTimer(this);
  timer_->setInterval(kPollMilliseconds);
  connect(timer_, &QTimer::timeout, this, [this]() { Poll(); });
}

void ComparisonBar::ShowWorkspace(const std::string& path) {
  workspace_path_ = path;
  other_path_->setText(QString::fromStdString(FindOtherWorkspace(path)));
}

void ComparisonBar::StartOrCancel() {
  if (run_ != nullptr) {
    run_->Progress().Abort();
    return;
  }
  if (other_path_->text().isEmpty()) {
    ShowError(this, "No workspace to compare with is given; choose a folder.");
    return;
  }
  ComparisonOptions options;
  options.workspace_paths = {workspace_path_,
                             other_path_->text().toStdString()};
  const fs::path folder =
      fs::path(DenseWorkspace(workspace_path_).ReportFolder()) / "comparison";
  run_ = std::make_unique<ComparisonRun>(options, folder.string());
  compare_button_->setText("Cancel");
  timer_->start();
}

void ComparisonBar::Poll() {
  if (!run_->HasEnded()) {
    const RunState state = run_->Progress().State();
    state_->setText(QString("%1: %2 %")
                        .arg(QString::fromStdString(state.stage))
                        .arg(static_cast<int>(100 * state.fraction)));
    return;
  }
  timer_->stop();
  const std::unique_ptr<ComparisonRun> run = std::move(run_);
  compare_button_->setText("Compare");
  state_->clear();
  if (!run->Error().empty()) {
    ShowError(this, run->Error());
  } else if (!run->PagePath().empty()) {
    const QString path = QString::fromStdString(run->PagePath());
    if (!QDesktopServices::openUrl(QUrl::fromLocalFile(path))) {
      ShowError(
          this,
          "No program opens the comparison; it is in " + run->PagePath() + ".");
    }
  }
}

std::string FindOtherWorkspace(const std::string& workspace_path) {
  std::error_code error;
  const fs::path workspace = fs::canonical(workspace_path, error);
  std::set<fs::path> found;
  for (const auto& entry :
       fs::directory_iterator(workspace.parent_path(), error)) {
    const fs::path maps = entry.path() / "stereo" / "depth_maps";
    if (entry.path() != workspace && fs::is_directory(maps, error) &&
        !fs::is_empty(maps, error)) {
      found.insert(entry.path());
    }
  }
  return found.empty() ? "" : found.begin()->string();
}

}  // namespace structnerf
