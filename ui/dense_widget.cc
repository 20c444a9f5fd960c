#include "ui/dense_widget.h"

#include "colmap_plugin/cloud_fusion.h"
#include "colmap_plugin/input_check.h"
#include "ui/error_dialog.h"
#include "ui/option_page.h"

#include <QCloseEvent>
#include <QMessageBox>
#include <QScrollArea>
#include <QVBoxLayout>
#include <filesystem>

#include <glog/logging.h>

namespace structnerf {
namespace {

// Which tab is where.
enum { kSetupTab, kAdvancedTab, kRunTab, kResultsTab };

// The options that the setup page does not have.
std::vector<OptionEntry> AdvancedEntries(StructNerfOptions* options) {
  std::vector<OptionEntry> entries;
  for (const OptionEntry& entry : MakeOptionTable(options)) {
    if (entry.name != "StructNeRF.quality" &&
        entry.name != "StructNeRF.method" &&
        entry.name != "StructNeRF.max_minutes" &&
        entry.name != "StructNeRF.device") {
      entries.push_back(entry);
    }
  }
  return entries;
}

// Beside the project, or beside the images.
std::string DefaultWorkspace(const ColmapLink& link) {
  const std::filesystem::path neighbor =
      link.ProjectPath().empty() ? link.ImagePath() : link.ProjectPath();
  return neighbor.empty()
             ? ""
             : (neighbor.parent_path() / "dense_structnerf").string();
}

}  // namespace

DenseWidget::DenseWidget(QWidget* main_window,
                         StructNerfOptions* options,
                         ColmapLink* link)
    : QWidget(main_window), options_(options), link_(link) {
  setWindowFlags(Qt::Window);
  setWindowTitle("StructNeRF dense reconstruction");
  resize(820, 640);
  auto* layout = new QVBoxLayout(this);
  tabs_ = new QTabWidget(this);
  tabs_->setObjectName("tabs");
  layout->addWidget(tabs_);

  setup_page_ = new SetupPage(
      options, [this]() { Start(); }, this);
  auto* advanced = new QScrollArea(this);
  advanced->setWidget(new OptionPage(AdvancedEntries(options), advanced));
  advanced->setWidgetResizable(true);
  advanced->setHorizontalScrollBarPolicy(Qt::ScrollBarAlwaysOff);
  run_page_ = new RunPage(
      [this]() {
        if (MayEndRun()) {
          EndRun();
        }
      },
      this);
  results_page_ = new ResultsPage(link, this);
  tabs_->addTab(setup_page_, "Setup");
  tabs_->addTab(advanced, "Advanced");
  tabs_->addTab(run_page_, "Run");
  tabs_->addTab(results_page_, "Results");
  tabs_->setTabEnabled(kRunTab, false);
  tabs_->setTabEnabled(kResultsTab, false);
  connect(tabs_, &QTabWidget::currentChanged, this, [this](const int tab) {
    // The advanced options have been written when their page went.
    if (tab == kSetupTab) {
      setup_page_->UpdateExpectation();
    }
  });

  timer_ = new QTimer(this);
  timer_->setInterval(kPollMilliseconds);
  connect(timer_, &QTimer::timeout, this, [this]() { Poll(); });
  main_window->installEventFilter(this);
}

void DenseWidget::Show() {
  const auto model = link_->Model();
  if (!IsRunning() && model != nullptr) {
    if (model_ != nullptr) {
      setup_page_->WriteOptions();  // else what was typed in would be lost
    }
    const std::string image_path = link_->ImagePath();
    if (!image_path.empty() && image_path != project_image_path_) {
      options_->image_path = image_path;
    }
    project_image_path_ = image_path;
    const std::string workspace = DefaultWorkspace(*link_);
    const bool is_other_project =
        !default_workspace_.empty() && workspace != default_workspace_;
    if (is_other_project) {
      // Neither results nor masks are those of this one.
      options_->mask_path.clear();
      options_->overwrite = false;
    }
    if (is_other_project || options_->output_path.empty()) {
      options_->output_path = workspace;
    }
    default_workspace_ = workspace;
    TakeModel(model);
    tabs_->setCurrentIndex(kSetupTab);
  }
  show();
  raise();
  activateWindow();
}

void DenseWidget::TakeModel(
    const std::shared_ptr<const colmap::Reconstruction>& model) {
  shown_model_ = model;
  // A copy: COLMAP may change its model, or forget it, while this one is worked
  // on.
  model_ = std::make_shared<const colmap::Reconstruction>(*model);
  setup_page_->ShowModel(model_);
}

void DenseWidget::Start() {
  if (options_->output_path.empty()) {
    ShowError(this, "No workspace is given; choose a folder for the results.");
    return;
  }
  if (link_->IsMapping()) {
    ShowError(this,
              "COLMAP is changing the model; pause its reconstruction, or wait "
              "for its end.");
    return;
  }
  if (DefaultWorkspace(*link_) != default_workspace_ ||
      link_->ImagePath() != project_image_path_) {
    Show();
    ShowError(this,
              "Another project has been opened; see whether images and "
              "workspace are right, and start again.");
    return;
  }
  // COLMAP may have changed it, or show another one, since the dialog came up.
  if (const auto model = link_->Model()) {
    TakeModel(model);
  }
  StructNerfOptions options = *options_;
  options.fusion = link_->FusionOptions();
  ForgetDefaultMinNumPixels(&options.fusion);
  run_ = std::make_unique<DenseRun>(options, model_);
  run_page_->ShowBegin(ImageNames(*model_), &run_->Progress());
  tabs_->setTabEnabled(kSetupTab, false);
  tabs_->setTabEnabled(kAdvancedTab, false);
  tabs_->setTabEnabled(kRunTab, true);
  tabs_->setCurrentIndex(kRunTab);
  timer_->start();
}

void DenseWidget::Poll() {
  run_page_->ShowState();
  if (run_->HasEnded()) {
    End();
  }
}

void DenseWidget::End() {
  timer_->stop();
  run_page_->ShowEnd();
  const std::unique_ptr<DenseRun> run = std::move(run_);
  tabs_->setTabEnabled(kSetupTab, true);
  tabs_->setTabEnabled(kAdvancedTab, true);
  switch (run->Status()) {
    case StructNerfController::Status::kSuccess:
      LOG(INFO) << "StructNeRF: " << run->Report().num_fused_points
                << " points in " << run->Report().workspace_path;
      tabs_->setTabEnabled(kResultsTab, true);
      tabs_->setCurrentIndex(kResultsTab);
      // The user may look at another one by now.
      results_page_->ShowResults(
          run->Report(),
          model_,
          link_->Model() != nullptr && link_->Model() == shown_model_.lock());
      break;
    case StructNerfController::Status::kAborted:
      LOG(WARNING) << "StructNeRF: cancelled; "
                   << (run->KeptPath().empty()
                           ? "nothing was written"
                           : "Start goes on from what was done, which is in " +
                                 run->KeptPath());
      tabs_->setTabEnabled(kRunTab, false);
      tabs_->setCurrentIndex(kSetupTab);
      break;
    default:
      tabs_->setTabEnabled(kRunTab, false);
      tabs_->setCurrentIndex(kSetupTab);
      ShowError(this,
                run->KeptPath().empty()
                    ? run->Error()
                    : run->Error() +
                          " Start goes on from what was done, which is in " +
                          run->KeptPath() + ".");
  }
}

bool DenseWidget::MayEndRun() {
  if (!IsRunning()) {
    return true;
  }
  const auto answer = QMessageBox::question(
      this,
      "",
      "The StructNeRF reconstruction has not ended. Save what it has learned, "
      "so that Start goes on from there another time, or discard it?",
      QMessageBox::Save | QMessageBox::Discard | QMessageBox::Cancel,
      QMessageBox::Cancel);
  should_save_ = answer == QMessageBox::Save;
  return answer == QMessageBox::Save || answer == QMessageBox::Discard;
}

void DenseWidget::EndRun() {
  if (!IsRunning()) {
    return;
  }
  if (should_save_) {
    run_->Progress().Suspend();
  } else {
    run_->Progress().Abort();
  }
  run_page_->ShowState();
}

void DenseWidget::closeEvent(QCloseEvent* event) {
  const bool may_end = MayEndRun();
  event->setAccepted(may_end);
  if (may_end) {
    EndRun();
  }
}

bool DenseWidget::eventFilter(QObject* object, QEvent* event) {
  if (event->type() == QEvent::Close && !MayEndRun()) {
    event->ignore();
    return true;
  }
  // Only now: after our question, COLMAP asks one of its own.
  if (event->type() == QEvent::Hide && !event->spontaneous()) {
    EndRun();
  }
  return QWidget::eventFilter(object, event);
}

}  // namespace structnerf
