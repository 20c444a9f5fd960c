#include "colmap_plugin/terminal_progress.h"

#include "nerf/util/interrupts.h"

#include <csignal>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace structnerf {
namespace {

using testing::EndsWith;
using testing::HasSubstr;
using testing::Not;

class TerminalProgressTest : public testing::Test {
 protected:
  TerminalProgress MakeProgress(bool is_terminal, int num_columns = 80) {
    return TerminalProgress(
        &stream_, {is_terminal, num_columns, [this]() { return seconds_; }});
  }

  // The new output since the last call.
  std::string Output() {
    const std::string text = stream_.str();
    stream_.str("");
    return text;
  }

  std::ostringstream stream_;
  double seconds_ = 100;
};

TEST_F(TerminalProgressTest, PlainLinesComeEveryTenth) {
  TerminalProgress progress = MakeProgress(false);
  progress.Report({"Training", 0});
  EXPECT_EQ(Output(), "Training\n");
  seconds_ += 5;
  progress.Report({"Training", 0.05, -1, 0.3});
  EXPECT_EQ(Output(), "");
  seconds_ += 5;
  progress.Report({"Training", 0.1, -1, 0.25, 20.5});
  EXPECT_EQ(Output(),
            "Training: 10 %, 1:30 min left, loss 0.2500, held-out PSNR 20.5 "
            "dB\n");
  seconds_ += 1;
  progress.Report({"Training", 0.19});
  EXPECT_EQ(Output(), "");
  progress.Report({"Training", 0.52, 7});
  EXPECT_EQ(Output(),
            "Training: 52 %, 7 s left, loss 0.2500, held-out PSNR 20.5 dB\n");
  progress.Report({"Training", 1});
  progress.Finish();
  EXPECT_EQ(Output(),
            "Training: done in 11 s, loss 0.2500, held-out PSNR 20.5 dB\n");
  progress.Finish();
  EXPECT_EQ(Output(), "");
}

TEST_F(TerminalProgressTest, NegativeLossIsShown) {
  TerminalProgress progress = MakeProgress(false);
  progress.Report({"Training", 0, -1, -0.5});
  seconds_ += 5;
  progress.Report({"Training", 0.5});
  EXPECT_THAT(Output(), HasSubstr("5 s left, loss -0.5000"));
}

TEST_F(TerminalProgressTest, PlainLinesComeAtMostOncePerSecond) {
  TerminalProgress progress = MakeProgress(false);
  for (int i = 0; i <= 100; ++i) {
    progress.Report({"Loading", i / 100.0});
    seconds_ += 0.001;
  }
  progress.Report({"Training", 0});
  EXPECT_EQ(Output(), "Loading\nLoading: done in 0 s\nTraining\n");
}

TEST_F(TerminalProgressTest, TerminalLineIsRedrawnInPlace) {
  TerminalProgress progress = MakeProgress(true);
  progress.Report({"Training", 0});
  seconds_ += 1;
  progress.Report({"Training", 0.5, -1, 0.25});
  const std::string drawn = Output();
  EXPECT_THAT(drawn, Not(HasSubstr("\n")));
  EXPECT_THAT(drawn,
              EndsWith("\r\033[KTraining             "
                       "[############............] 50 %, 1 s left, loss "
                       "0.2500"));
  progress.Report({"Training", 0.6});
  EXPECT_EQ(Output(), "") << "drawn too often";
  progress.Finish();
  EXPECT_EQ(Output(), "\r\033[KTraining             1 s\n");
}

TEST_F(TerminalProgressTest, TerminalLineNeverWraps) {
  TerminalProgress progress = MakeProgress(true, 30);
  progress.Report({"Training", 0.5, 1000, 0.25, 20});
  const std::string drawn = Output();
  EXPECT_LE(drawn.size(), std::string("\r\033[K").size() + 29);
}

TEST_F(TerminalProgressTest, SentencesDoNotTearTheLine) {
  TerminalProgress progress = MakeProgress(true);
  progress.Report({"Training", 0.5});
  Output();
  progress.Warn("Something.");
  const std::string text = Output();
  EXPECT_EQ(text.find("\r\033[KWarning: Something.\n\r\033[KTraining"), 0);
}

TEST_F(TerminalProgressTest, FractionsOutOfRangeAreHarmless) {
  TerminalProgress progress = MakeProgress(true);
  progress.Report({"Training", -1});
  seconds_ += 1;
  progress.Report({"Training", 7});
  EXPECT_THAT(Output(), HasSubstr("100 %"));
}

TEST_F(TerminalProgressTest, CtrlCStopsThenAborts) {
  const ScopedInterrupts interrupts;
  TerminalProgress progress = MakeProgress(false);
  EXPECT_FALSE(progress.ShouldStop());
  EXPECT_FALSE(progress.ShouldAbort());
  std::raise(SIGINT);
  EXPECT_TRUE(progress.ShouldStop());
  EXPECT_TRUE(progress.ShouldStop());
  EXPECT_FALSE(progress.ShouldAbort());
  const std::string text = Output();
  EXPECT_THAT(text, HasSubstr("Ctrl-C again"));
  EXPECT_EQ(text.find("Ctrl-C"), text.rfind("Ctrl-C")) << "said twice";
  std::raise(SIGINT);
  EXPECT_TRUE(progress.ShouldAbort());
}

}  // namespace
}  // namespace structnerf
