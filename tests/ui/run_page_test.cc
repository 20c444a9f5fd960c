// Pausing, stopping and leaving a run in COLMAP's window.

#include "ui/run_page.h"

#include "tests/support/synthetic_room.h"
#include "tests/support/synthetic_room_writer.h"
#include "tests/ui/dense_window_fixture.h"

#include <QElapsedTimer>
#include <QLabel>
#include <QLineEdit>
#include <QProgressBar>
#include <QPushButton>
#include <QTest>
#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace structnerf {
namespace {

namespace fs = std::filesystem;

using testing::HasSubstr;

class RunPageTest : public DenseWindowFixture {
 protected:
  // That does not end before it is told to; whether it is under way.
  bool StartLongTraining() {
    OpenDialog();
    SetNumSteps(1000000);
    Click("start");
    return WaitForTraining();
  }
};

// COLMAP closes its model when another project is begun.
TEST_F(RunPageTest, RunsOnTheModelThatItShows) {
  OpenDialog();
  SetNumSteps(1000000);
  Viewer()->reconstruction = nullptr;
  Click("start");
  ASSERT_TRUE(WaitForTraining());
  AnswerMessage(QMessageBox::Discard, "message_cancel");
  Click("cancel");
  ASSERT_TRUE(WaitForTab(0));
}

// The others are over too soon to be caught on every machine.
TEST_F(RunPageTest, LongStagesAnswerAtOnce) {
  SyntheticRoomOptions room_options;
  room_options.num_views = 30;
  WriteSyntheticRoom(MakeSyntheticRoom(room_options), *temp_dir_ / "large");
  OpenDialog("large");
  Find<QLineEdit>("image_path")
      ->setText(QString::fromStdString(*temp_dir_ / "large/images"));
  const auto* bar = Find<QProgressBar>("bar");
  const auto* stage = Find<QLabel>("stage");
  for (const char* const name : {"Training", "Rendering depth maps"}) {
    SCOPED_TRACE(name);
    SetNumSteps(std::string(name) == "Training" ? 2000 : 20);
    Click("start");
    ASSERT_TRUE(QTest::qWaitFor(
        [&]() { return stage->text() == name && bar->value() > 0; },
        kRunMilliseconds));
    Click("pause");
    QTest::qWait(kAnswerMilliseconds);
    ASSERT_EQ(stage->text(), QString(name) + " (paused)");
    const int paused_value = bar->value();
    QTest::qWait(500);
    EXPECT_EQ(bar->value(), paused_value);

    QElapsedTimer timer;
    timer.start();
    Click("pause");
    EXPECT_TRUE(QTest::qWaitFor(
        [&]() { return bar->value() != paused_value || stage->text() != name; },
        kRunMilliseconds));
    EXPECT_LT(timer.elapsed(), kAnswerMilliseconds);

    timer.start();
    AnswerMessage(QMessageBox::Discard, "message_cancel");
    Click("cancel");
    ASSERT_TRUE(WaitForTab(0));
    EXPECT_LT(timer.elapsed(), kAnswerMilliseconds);
    EXPECT_FALSE(fs::exists(WorkspacePath()));
  }
}

TEST_F(RunPageTest, StopKeepsWhatWasLearned) {
  ASSERT_TRUE(StartLongTraining());
  QElapsedTimer timer;
  timer.start();
  Click("stop");
  EXPECT_FALSE(Find<QPushButton>("stop")->isEnabled());
  EXPECT_TRUE(QTest::qWaitFor(
      [this]() { return Find<QProgressBar>("bar")->value() == 1000; },
      kAnswerMilliseconds));
  EXPECT_LT(timer.elapsed(), kAnswerMilliseconds);
  ASSERT_TRUE(WaitForTab(3)) << message_;
  EXPECT_TRUE(fs::exists(WorkspacePath() + "/fused.ply"));
}

TEST_F(RunPageTest, CancelAsksAndWritesNothing) {
  ASSERT_TRUE(StartLongTraining());
  AnswerMessage(QMessageBox::Cancel, "message_cancel");
  Click("cancel");
  EXPECT_THAT(message_, HasSubstr("has not ended"));
  EXPECT_EQ(Tabs()->currentIndex(), 2);
  QElapsedTimer timer;
  timer.start();
  AnswerMessage(QMessageBox::Discard, "message_cancel");
  Click("cancel");
  ASSERT_TRUE(WaitForTab(0));
  EXPECT_LT(timer.elapsed(), kAnswerMilliseconds);
  EXPECT_FALSE(fs::exists(WorkspacePath()));
  EXPECT_TRUE(Find<QPushButton>("start")->isEnabled());
}

TEST_F(RunPageTest, WhatIsSavedIsGoneOnWith) {
  ASSERT_TRUE(StartLongTraining());
  AnswerMessage(QMessageBox::Save, "message_cancel");
  Click("cancel");
  ASSERT_TRUE(WaitForTab(0));
  EXPECT_FALSE(fs::exists(WorkspacePath() + "/fused.ply"));
  EXPECT_TRUE(QTest::qWaitFor([this]() {
    return Log().contains("Start goes on from what was done");
  })) << Log().toStdString();
  Click("start");
  ASSERT_TRUE(WaitForTraining());
  EXPECT_TRUE(QTest::qWaitFor([this]() {
    return Log().contains("Going on with the run");
  })) << Log().toStdString();
  Click("stop");
  ASSERT_TRUE(WaitForTab(3)) << message_;
}

TEST_F(RunPageTest, StartWaitsForCOLMAPsMapper) {
  OpenDialog();
  auto* pause = PauseAction();
  pause->setEnabled(true);
  AnswerMessage(QMessageBox::Ok, "message_mapping");
  Click("start");
  EXPECT_TRUE(QTest::qWaitFor([&]() { return !message_.empty(); },
                              kAnswerMilliseconds));
  EXPECT_THAT(message_, HasSubstr("COLMAP is changing the model"));
  EXPECT_EQ(Tabs()->currentIndex(), 0);
  pause->setEnabled(false);
}

TEST_F(RunPageTest, AnotherProjectsImagesAreNotTakenUnseen) {
  OpenDialog();
  const auto* image_path = Find<QLineEdit>("image_path");
  *image_path_ = *temp_dir_ / "other/images";
  AnswerMessage(QMessageBox::Ok, "message_other_project");
  Click("start");
  EXPECT_TRUE(QTest::qWaitFor([&]() { return !message_.empty(); },
                              kAnswerMilliseconds));
  EXPECT_THAT(message_, HasSubstr("Another project"));
  EXPECT_EQ(Tabs()->currentIndex(), 0);
  EXPECT_EQ(image_path->text().toStdString(), *temp_dir_ / "other/images");
  EXPECT_EQ(Find<QLineEdit>("workspace_path")->text().toStdString(),
            *temp_dir_ / "other/dense_structnerf");
}

TEST_F(RunPageTest, TheCloudDoesNotTakeThePlaceOfAnotherModel) {
  ASSERT_TRUE(StartLongTraining());
  window_->Window().ImportReconstruction(*temp_dir_ / "room/sparse/0");
  const auto shown = Viewer()->reconstruction;
  Click("stop");
  ASSERT_TRUE(WaitForTab(3)) << message_;
  EXPECT_TRUE(Find<QPushButton>("show_cloud")->isEnabled());
  EXPECT_EQ(Viewer()->reconstruction, shown);
}

TEST_F(RunPageTest, ClosingInTheMiddleAsks) {
  ASSERT_TRUE(StartLongTraining());
  AnswerMessage(QMessageBox::Cancel, "message_close");
  EXPECT_FALSE(Tabs()->window()->close());
  EXPECT_THAT(message_, HasSubstr("has not ended"));
  EXPECT_EQ(Tabs()->currentIndex(), 2);
  AnswerMessage(QMessageBox::Cancel, "message_close_main_window");
  EXPECT_FALSE(window_->Window().close());
  // An end in our question, but no to COLMAP's own.
  OnMessage([this](QMessageBox* box) {
    Answer(box, QMessageBox::Discard, "message_close_main_window");
    AnswerMessage(QMessageBox::No, "message_quit");
  });
  EXPECT_FALSE(window_->Window().close());
  EXPECT_THAT(message_, HasSubstr("quit"));
  QTest::qWait(kAnswerMilliseconds);
  EXPECT_EQ(Tabs()->currentIndex(), 2);
  AnswerMessage(QMessageBox::Discard, "message_close");
  EXPECT_TRUE(Tabs()->window()->close());
  ASSERT_TRUE(WaitForTab(0));
  EXPECT_FALSE(fs::exists(WorkspacePath()));
}

TEST_F(RunPageTest, ClosingTheMainWindowCancels) {
  ASSERT_TRUE(StartLongTraining());
  OnMessage([this](QMessageBox* box) {
    Answer(box, QMessageBox::Discard, "message_close_main_window");
    // COLMAP's own question.
    AnswerMessage(QMessageBox::Yes, "message_quit");
  });
  EXPECT_TRUE(window_->Window().close());
  EXPECT_THAT(message_, HasSubstr("quit"));
  EXPECT_FALSE(window_->Window().isVisible());
  QElapsedTimer timer;
  timer.start();
  ASSERT_TRUE(WaitForTab(0));
  EXPECT_LT(timer.elapsed(), kAnswerMilliseconds);
  EXPECT_FALSE(fs::exists(WorkspacePath()));
}

TEST_F(RunPageTest, ARunMayEndWhileTheQuestionIsOpen) {
  ASSERT_TRUE(StartLongTraining());
  OnMessage([this](QMessageBox* box) {
    Click("stop");
    EXPECT_TRUE(WaitForTab(3));
    Answer(box, QMessageBox::Discard, "message_close");
  });
  EXPECT_TRUE(Tabs()->window()->close());
  EXPECT_TRUE(fs::exists(WorkspacePath() + "/fused.ply"));
}

}  // namespace
}  // namespace structnerf
