#include "ui/gui_progress.h"

#include <chrono>
#include <thread>

#include <gtest/gtest.h>

namespace structnerf {
namespace {

using Clock = std::chrono::steady_clock;

ProgressUpdate MakeUpdate(const std::string& stage, const double fraction) {
  ProgressUpdate update;
  update.stage = stage;
  update.fraction = fraction;
  return update;
}

TEST(GuiProgress, StateIsWhatWasReportedLast) {
  GuiProgress progress;
  ProgressUpdate update = MakeUpdate("Training", 0.25);
  update.seconds_left = 12;
  update.loss = 0.5;
  progress.Report(update);
  update.fraction = 0.5;
  update.loss = -0.25;
  update.held_out_psnr = 20;
  progress.Report(update);
  const RunState state = progress.State();
  EXPECT_EQ(state.stage, "Training");
  EXPECT_EQ(state.fraction, 0.5);
  EXPECT_EQ(state.seconds_left, 12);
  ASSERT_EQ(state.loss.size(), 2u);
  EXPECT_EQ(state.loss[0].fraction, 0.25);
  EXPECT_EQ(state.loss[1].value, -0.25);
  ASSERT_EQ(state.held_out_psnr.size(), 1u);
  EXPECT_EQ(state.held_out_psnr[0].value, 20);
}

TEST(GuiProgress, RemainingTimeIsGuessedFromTheStage) {
  GuiProgress progress;
  progress.Report(MakeUpdate("Fusing points", 0));
  EXPECT_EQ(progress.State().seconds_left, -1);
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  progress.Report(MakeUpdate("Fusing points", 0.5));
  EXPECT_GE(progress.State().seconds_left, 0.2);
  EXPECT_LT(progress.State().seconds_left, 10);
}

TEST(GuiProgress, StopAndAbortReachTheRun) {
  GuiProgress progress;
  EXPECT_FALSE(progress.ShouldStop());
  EXPECT_FALSE(progress.ShouldAbort());
  progress.Stop();
  EXPECT_TRUE(progress.ShouldStop());
  EXPECT_FALSE(progress.ShouldAbort());
  EXPECT_TRUE(progress.State().is_stopping);
  progress.Abort();
  EXPECT_TRUE(progress.ShouldAbort());
}

TEST(GuiProgress, APausedRunWaitsUntilItIsResumedOrEnded) {
  for (void (*const wake)(GuiProgress*) :
       {+[](GuiProgress* progress) { progress->SetPaused(false); },
        +[](GuiProgress* progress) { progress->Stop(); },
        +[](GuiProgress* progress) { progress->Abort(); }}) {
    GuiProgress progress;
    progress.BlockWhilePaused();
    progress.SetPaused(true);
    EXPECT_TRUE(progress.State().is_paused);
    const auto begin = Clock::now();
    std::thread window([&]() {
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
      wake(&progress);
    });
    progress.BlockWhilePaused();
    EXPECT_GE(Clock::now() - begin, std::chrono::milliseconds(90));
    window.join();
    EXPECT_FALSE(progress.State().is_paused);
  }
}

TEST(GuiProgress, AnEndingRunIsNotPaused) {
  GuiProgress progress;
  progress.Stop();
  progress.SetPaused(true);
  progress.BlockWhilePaused();
  EXPECT_FALSE(progress.State().is_paused);
}

TEST(GuiProgress, PreviewsArePassedOn) {
  GuiProgress progress;
  EXPECT_EQ(progress.PreviewImage(), "");
  progress.WatchImage("a.png");
  EXPECT_EQ(progress.PreviewImage(), "a.png");
  EXPECT_EQ(progress.State().preview, nullptr);
  Preview preview;
  preview.view_idx = 3;
  progress.ShowPreview(preview);
  ASSERT_NE(progress.State().preview, nullptr);
  EXPECT_EQ(progress.State().preview->view_idx, 3);
}

}  // namespace
}  // namespace structnerf
