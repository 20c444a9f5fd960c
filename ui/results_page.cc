#include "ui/results_page.h"

#include "ui/cloud_model.h"
#include "ui/error_dialog.h"

#include <QDesktopServices>
#include <QFontDatabase>
#include <QHBoxLayout>
#include <QHeaderView>
#include <QUrl>
#include <QVBoxLayout>
#include <chrono>
#include <utility>

namespace structnerf {
namespace {

QTableWidgetItem* PercentItem(const size_t count,
                              const int width,
                              const int height) {
  const double percent = 100.0 * static_cast<double>(count) /
                         (static_cast<double>(width) * height);
  return new QTableWidgetItem(QString::number(percent, 'f', 1) + " %");
}

}  // namespace

ResultsPage::ResultsPage(ColmapLink* link, QWidget* parent)
    : QWidget(parent), link_(link) {
  auto* layout = new QVBoxLayout(this);
  summary_ = new QPlainTextEdit(this);
  summary_->setObjectName("summary");
  summary_->setReadOnly(true);
  summary_->setFont(QFontDatabase::systemFont(QFontDatabase::FixedFont));
  layout->addWidget(summary_, 2);

  views_ = new QTableWidget(this);
  views_->setObjectName("views");
  views_->setColumnCount(4);
  views_->setHorizontalHeaderLabels(
      {"image_name", "size", "photometric", "geometric"});
  views_->setSelectionBehavior(QAbstractItemView::SelectRows);
  views_->setSelectionMode(QAbstractItemView::SingleSelection);
  views_->setEditTriggers(QAbstractItemView::NoEditTriggers);
  views_->horizontalHeader()->setStretchLastSection(true);
  connect(views_, &QTableWidget::cellDoubleClicked, this, [this](int, int) {
    ShowErrorOf(this, [this]() { OpenMap(MapViewer::Kind::kDepth); });
  });
  layout->addWidget(views_, 3);

  buttons_ = new QWidget(this);
  auto* row = new QHBoxLayout(buttons_);
  row->setContentsMargins(0, 0, 0, 0);
  map_type_ = new QComboBox(buttons_);
  map_type_->setObjectName("map_type");
  map_type_->addItems({"geometric", "photometric"});
  map_type_->setToolTip(
      "Pixels that other views confirm, or every confident pixel");
  row->addWidget(map_type_);
  AddButton(
      "Depth map", "depth_map", [this]() { OpenMap(MapViewer::Kind::kDepth); });
  AddButton("Normal map", "normal_map", [this]() {
    OpenMap(MapViewer::Kind::kNormal);
  });
  AddButton("Confidence", "confidence", [this]() { OpenConfidence(); });
  AddButton("Photograph", "photograph", [this]() { OpenPhotograph(); });
  row->addStretch(1);
  cloud_button_ =
      AddButton("Show cloud", "show_cloud", [this]() { ReadCloud(); });
  AddButton(
      "Show sparse model", "show_model", [this]() { link_->ShowModel(); });
  AddButton("Open folder", "open_folder", [this]() {
    QDesktopServices::openUrl(
        QUrl::fromLocalFile(QString::fromStdString(workspace_->Path())));
  });
  buttons_->setEnabled(false);
  layout->addWidget(buttons_);
  comparison_bar_ = new ComparisonBar(this);
  comparison_bar_->setEnabled(false);
  layout->addWidget(comparison_bar_);

  map_viewer_ = new MapViewer(this);
  timer_ = new QTimer(this);
  timer_->setInterval(kPollMilliseconds);
  connect(timer_, &QTimer::timeout, this, [this]() { PollCloud(); });
}

QPushButton* ResultsPage::AddButton(const QString& text,
                                    const char* name,
                                    std::function<void()> action) {
  auto* button = new QPushButton(text, buttons_);
  button->setObjectName(name);
  connect(button,
          &QPushButton::clicked,
          this,
          [this, action = std::move(action)]() { ShowErrorOf(this, action); });
  buttons_->layout()->addWidget(button);
  return button;
}

void ResultsPage::ShowResults(
    const RunReport& report,
    std::shared_ptr<const colmap::Reconstruction> model,
    const bool shows_cloud) {
  workspace_ = std::make_unique<DenseWorkspace>(report.workspace_path);
  model_ = std::move(model);
  summary_->setPlainText(QString::fromStdString(ReportText(report)));
  views_->setRowCount(static_cast<int>(report.views.size()));
  for (int row = 0; row < views_->rowCount(); ++row) {
    const ViewReport& view = report.views[row];
    views_->setItem(
        row, 0, new QTableWidgetItem(QString::fromStdString(view.name)));
    views_->setItem(row,
                    1,
                    new QTableWidgetItem(
                        QString("%1 x %2").arg(view.width).arg(view.height)));
    views_->setItem(
        row, 2, PercentItem(view.num_photometric, view.width, view.height));
    views_->setItem(
        row, 3, PercentItem(view.num_geometric, view.width, view.height));
  }
  views_->resizeColumnsToContents();
  views_->selectRow(0);
  buttons_->setEnabled(true);
  comparison_bar_->ShowWorkspace(report.workspace_path);
  comparison_bar_->setEnabled(true);
  if (shows_cloud) {
    ShowErrorOf(this, [this]() { ReadCloud(); });
  }
}

void ResultsPage::ReadCloud() {
  cloud_ = std::async(std::launch::async,
                      [model = model_, path = workspace_->FusedPath()]() {
                        return MakeCloudModel(*model, path);
                      });
  cloud_button_->setEnabled(false);
  timer_->start();
}

void ResultsPage::PollCloud() {
  if (cloud_.wait_for(std::chrono::seconds(0)) == std::future_status::ready) {
    timer_->stop();
    cloud_button_->setEnabled(true);
    ShowErrorOf(this, [this]() { link_->ShowCloud(cloud_.get()); });
  }
}

void ResultsPage::OpenMap(const MapViewer::Kind kind) {
  const std::string name = ChosenImage();
  if (name.empty()) {
    return;
  }
  const bool is_geometric = map_type_->currentIndex() == 0;
  map_viewer_->ShowMap(
      QString(kind == MapViewer::Kind::kDepth ? "Depth map for %1"
                                              : "Normal map for %1")
          .arg(QString::fromStdString(name)),
      kind,
      workspace_->ReadMaps(
          name, is_geometric ? MapType::kGeometric : MapType::kPhotometric));
}

void ResultsPage::OpenConfidence() {
  const std::string name = ChosenImage();
  if (!name.empty()) {
    FloatArray confidence = workspace_->ReadConfidence(name);
    map_viewer_->ShowMap(
        QString("Confidence for %1").arg(QString::fromStdString(name)),
        MapViewer::Kind::kConfidence,
        {confidence.width,
         confidence.height,
         std::move(confidence.values),
         {}});
  }
}

void ResultsPage::OpenPhotograph() {
  const std::string name = ChosenImage();
  if (!name.empty()) {
    map_viewer_->ShowPhotograph(
        QString("Image for %1").arg(QString::fromStdString(name)),
        QString::fromStdString(workspace_->ImagePath(name)));
  }
}

std::string ResultsPage::ChosenImage() const {
  const int row = views_->currentRow();
  return row < 0 ? "" : views_->item(row, 0)->text().toStdString();
}

}  // namespace structnerf
