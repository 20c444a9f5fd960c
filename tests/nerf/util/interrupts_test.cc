#include "nerf/util/interrupts.h"

#include <csignal>

#include <gtest/gtest.h>

namespace structnerf {
namespace {

TEST(Interrupts, CountsFromZeroInEachScope) {
  {
    const ScopedInterrupts interrupts;
    EXPECT_EQ(ScopedInterrupts::Count(), 0);
    std::raise(SIGINT);
    EXPECT_EQ(ScopedInterrupts::Count(), 1);
    std::raise(SIGINT);
    EXPECT_EQ(ScopedInterrupts::Count(), 2);
    EXPECT_FALSE(ScopedInterrupts::WasTerminated());
  }
  EXPECT_EQ(ScopedInterrupts::Count(), 0);
  const ScopedInterrupts interrupts;
  EXPECT_EQ(ScopedInterrupts::Count(), 0);
}

TEST(Interrupts, TerminationCountsAsTwo) {
  const ScopedInterrupts interrupts;
  EXPECT_FALSE(ScopedInterrupts::WasTerminated());
  std::raise(SIGTERM);
  EXPECT_EQ(ScopedInterrupts::Count(), 2);
  EXPECT_TRUE(ScopedInterrupts::WasTerminated());
}

void InterruptThrice() {
  const ScopedInterrupts interrupts;
  for (int i = 0; i < 3; ++i) {
    std::raise(SIGINT);
  }
}

TEST(InterruptsDeathTest, ThirdEndsTheProcess) {
  EXPECT_EXIT(InterruptThrice(), testing::ExitedWithCode(128 + SIGINT), "");
}

void InterruptAfterwards() {
  { const ScopedInterrupts interrupts; }
  std::raise(SIGINT);
}

TEST(InterruptsDeathTest, RestoresThePreviousBehaviour) {
  EXPECT_EXIT(InterruptAfterwards(), testing::KilledBySignal(SIGINT), "");
}

}  // namespace
}  // namespace structnerf
