#include "colmap_plugin/child_process.h"

#include <gtest/gtest.h>

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
