#pragma once

#include "colmap_plugin/structnerf_options.h"
#include "ui/colmap_link.h"
#include "ui/dense_run.h"
#include "ui/results_page.h"
#include "ui/run_page.h"
#include "ui/setup_page.h"

#include <QTabWidget>
#include <QTimer>
#include <QWidget>
#include <memory>

namespace structnerf {

// The window of the dense stage: its options, the run, and the results, one tab
// each.
class DenseWidget : public QWidget {
 public:
  // A child of COLMAP's window. `options` and `link` must outlive it.
  DenseWidget(QWidget* main_window,
              StructNerfOptions* options,
              ColmapLink* link);

  // Comes up with the model that COLMAP's viewer shows.
  void Show();

  bool IsRunning() const { return run_ != nullptr; }

 protected:
  void closeEvent(QCloseEvent* event) override;

  // Of COLMAP's window, which must not close in the middle of a run unasked.
  bool eventFilter(QObject* object, QEvent* event) override;

 private:
  // Takes the model that COLMAP shows, not null.
  void TakeModel(const std::shared_ptr<const colmap::Reconstruction>& model);
  void Start();
  void Poll();
  void End();

  // In the middle of a run, asks whether it may end, and whether what it has
  // done shall be saved.
  bool MayEndRun();
  void EndRun();

  StructNerfOptions* const options_;
  ColmapLink* const link_;
  QTabWidget* tabs_;
  SetupPage* setup_page_;
  RunPage* run_page_;
  ResultsPage* results_page_;
  QTimer* timer_;
  std::unique_ptr<DenseRun> run_;
  std::shared_ptr<const colmap::Reconstruction> model_;  // shown or worked on

  // The object that COLMAP showed when the model was taken from it.
  std::weak_ptr<const colmap::Reconstruction> shown_model_;

  // Of the project that was open when the window came up.
  std::string default_workspace_;
  std::string project_image_path_;

  bool should_save_ = false;  // what the user said when asked last
};

}  // namespace structnerf
