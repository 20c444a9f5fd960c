#include "colmap_plugin/child_process.h"

#include "nerf/util/interrupts.h"

#include <chrono>
#include <thread>

#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

namespace structnerf {
namespace {

TEST(ChildProcess, ReturnsTheExitCode) {
  EXPECT_EQ(RunChildProcess("/bin/sh", {"-c", "exit 0"}, true), 0);
  EXPECT_EQ(RunChildProcess("/bin/sh", {"-c", "exit 7"}, false), 7);
}

TEST(ChildProcess, ASignalIsAFailure) {
  EXPECT_EQ(RunChildProcess("/bin/sh", {"-c", "kill -9 $$"}, true), -1);
}

TEST(ChildProcess, AMissingProgramIsAFailure) {
  EXPECT_NE(RunChildProcess("/no/such/program", {}, true), 0);
}

TEST(ChildProcess, IsTerminatedWithUs) {
  const ScopedInterrupts interrupts;
  std::thread terminator([]() {
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    kill(getpid(), SIGTERM);
  });
  EXPECT_EQ(
      RunChildProcess("/bin/sh",
                      {"-c", "trap 'kill $!; exit 5' TERM; sleep 60 & wait"},
                      true),
      5);
  terminator.join();
}

TEST(ChildProcess, OutputIsKeptOrNot) {
  for (const bool keep_output : {true, false}) {
    testing::internal::CaptureStdout();
    EXPECT_EQ(RunChildProcess("/bin/echo", {"hello there"}, keep_output), 0);
    EXPECT_EQ(testing::internal::GetCapturedStdout(),
              keep_output ? "hello there\n" : "");
  }
}

}  // namespace
}  // namespace structnerf
