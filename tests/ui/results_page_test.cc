#include "ui/results_page.h"

#include "colmap_plugin/input_check.h"
#include "tests/colmap_plugin/tiny_model.h"
#include "tests/support/temp_dir.h"

#include <QLabel>
#include <QMainWindow>
#include <QMessageBox>
#include <QTest>
#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace structnerf {
namespace {

using testing::HasSubstr;

class ResultsPageTest : public testing::Test {
 protected:
  ResultsPageTest()
      : link_(manager_),
        viewer_(new colmap::ModelViewerWidget(&window_, &manager_)),
        page_(&link_, &window_) {
    MakeTinyModel(3).WriteModel(folder_ / "model");
    model_ =
        std::make_shared<colmap::Reconstruction>(ReadModel(folder_ / "model"));
    viewer_->reconstruction = model_;
    viewer_->statusbar_status_label = new QLabel(&window_);
    link_.SetViewer(viewer_);
    window_.setCentralWidget(viewer_);
    window_.resize(1024, 600);
    window_.show();
    EXPECT_TRUE(QTest::qWaitForWindowExposed(&window_));
    std::filesystem::create_directory(folder_ / "dense");
    report_.workspace_path = folder_ / "dense";
  }

  const TempDir folder_;
  std::shared_ptr<colmap::Reconstruction> model_;
  RunReport report_;
  colmap::OptionManager manager_;
  ColmapLink link_;
  QMainWindow window_;
  colmap::ModelViewerWidget* viewer_;
  ResultsPage page_;
};

TEST_F(ResultsPageTest, ACloudThatIsGoneIsNamedInADialog) {
  std::string message;
  QTimer timer;
  QObject::connect(&timer, &QTimer::timeout, [&]() {
    if (auto* box = page_.findChild<QMessageBox*>()) {
      message = box->text().toStdString();
      box->close();
    }
  });
  timer.start(50);
  page_.ShowResults(report_, model_, /*shows_cloud=*/true);
  EXPECT_TRUE(QTest::qWaitFor([&]() { return !message.empty(); }));
  EXPECT_TRUE(page_.findChild<QPushButton*>("show_cloud")->isEnabled());
  EXPECT_THAT(message, HasSubstr("fused.ply"));
  EXPECT_EQ(viewer_->reconstruction, model_);
}

}  // namespace
}  // namespace structnerf
