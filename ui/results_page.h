#pragma once

#include "colmap_plugin/dense_workspace.h"
#include "colmap_plugin/run_report.h"
#include "ui/colmap_link.h"
#include "ui/comparison_bar.h"
#include "ui/map_viewer.h"

#include <QComboBox>
#include <QPlainTextEdit>
#include <QPushButton>
#include <QTableWidget>
#include <QTimer>
#include <QWidget>
#include <functional>
#include <future>
#include <memory>

namespace structnerf {

// What a run has made: its summary, the maps of each view, and the cloud in
// COLMAP's viewer.
class ResultsPage : public QWidget {
 public:
  // `link` must outlive this object.
  ResultsPage(ColmapLink* link, QWidget* parent);

  // `model` is the one the run was made from. `shows_cloud`: whether the cloud
  // takes its place in COLMAP's viewer without being asked for.
  void ShowResults(const RunReport& report,
                   std::shared_ptr<const colmap::Reconstruction> model,
                   bool shows_cloud);

 private:
  QPushButton* AddButton(const QString& text,
                         const char* name,
                         std::function<void()> action);

  // Reads the cloud on a thread of its own, since millions of points take
  // seconds, and shows it when it is there.
  void ReadCloud();
  void PollCloud();

  void OpenMap(MapViewer::Kind kind);
  void OpenConfidence();
  void OpenPhotograph();

  // Name of the chosen view's image; empty if none is chosen.
  std::string ChosenImage() const;

  ColmapLink* const link_;
  std::unique_ptr<DenseWorkspace> workspace_;
  std::shared_ptr<const colmap::Reconstruction> model_;
  std::future<std::shared_ptr<colmap::Reconstruction>> cloud_;  // being read
  QPlainTextEdit* summary_;
  QTableWidget* views_;
  QComboBox* map_type_;
  QWidget* buttons_;
  QPushButton* cloud_button_;
  ComparisonBar* comparison_bar_;
  MapViewer* map_viewer_;
  QTimer* timer_;
};

}  // namespace structnerf
