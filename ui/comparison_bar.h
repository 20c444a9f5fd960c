#pragma once

#include "colmap_plugin/dense_workspace.h"
#include "ui/comparison_run.h"

#include <QLabel>
#include <QLineEdit>
#include <QPushButton>
#include <QTimer>
#include <QWidget>
#include <memory>
#include <string>

namespace structnerf {

// A row of widgets that compares a workspace with another one, for instance
// PatchMatch's, and opens the page in the browser.
class ComparisonBar : public QWidget {
 public:
  explicit ComparisonBar(QWidget* parent);

  // The workspace that is compared. Another dense workspace beside it, if there
  // is one, is proposed to compare it with.
  void ShowWorkspace(const std::string& path);

 private:
  void StartOrCancel();
  void Poll();

  std::string workspace_path_;
  QLineEdit* other_path_;
  QPushButton* compare_button_;
  QLabel* state_;
  QTimer* timer_;
  std::unique_ptr<ComparisonRun> run_;  // null = none is under way
};

// A folder with dense maps beside that of a workspace; empty if there is none.
std::string FindOtherWorkspace(const std::string& workspace_path);

}  // namespace structnerf
