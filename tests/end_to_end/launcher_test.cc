#include "tests/end_to_end/run_program.h"
#include "tests/support/temp_dir.h"

#include <csignal>
#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace structnerf {
namespace {

namespace fs = std::filesystem;

using testing::HasSubstr;

// A shell script stands for the stock colmap.
class LauncherTest : public testing::Test {
 protected:
  void MakeStock(const std::string& script) {
    const std::string path = temp_dir_ / "stock";
    std::ofstream(path) << "#!/bin/sh\n" << script;
    fs::permissions(path, fs::perms::owner_all);
    options_.environment["COLMAP_STRUCTNERF_STOCK_COLMAP"] = path;
  }

  TempDir temp_dir_;
  ProgramOptions options_;
};

TEST_F(LauncherTest, HandsOverArgumentsInputAndExitCode) {
  MakeStock("for a in \"$@\"; do echo \"<$a>\"; done\ncat\nexit 7\n");
  options_.arguments = {"mapper", "--image_path", "my images", "", "*", "-h"};
  options_.input = "from outside\n";
  const ProgramResult result = RunProgram(options_);
  EXPECT_EQ(result.exit_code, 7);
  EXPECT_EQ(result.out,
            "<mapper>\n<--image_path>\n<my images>\n<>\n<*>\n<-h>\n"
            "from outside\n");
  EXPECT_EQ(result.error, "");
}

TEST_F(LauncherTest, HandsOverSignals) {
  MakeStock(
      "trap 'echo caught; exit 3' INT\necho ready >&2\n"
      "while :; do sleep 0.05; done\n");
  options_.arguments = {"mapper"};
  Program program(options_);
  ASSERT_TRUE(program.WaitForError("ready"));
  program.Signal(SIGINT);
  const ProgramResult result = program.Wait();
  EXPECT_EQ(result.exit_code, 3);
  EXPECT_EQ(result.out, "caught\n");

  MakeStock("kill -TERM $$\n");
  EXPECT_EQ(RunProgram(options_).signal, SIGTERM);
}

TEST_F(LauncherTest, HelpIsTheStockHelpAndOurs) {
  MakeStock("echo \"stock $1\"\n");
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{}, {"help"}, {"-h"}, {"--help"}}) {
    options_.arguments = arguments;
    const ProgramResult result = RunProgram(options_);
    EXPECT_EQ(result.exit_code, 0);
    EXPECT_EQ(result.out.find("stock help\n"), 0);
    EXPECT_THAT(result.out, HasSubstr("structnerf_dense"));
  }
}

TEST_F(LauncherTest, SaysWhatIsWrongWithoutStockColmap) {
  options_.environment["COLMAP_STRUCTNERF_STOCK_COLMAP"] = temp_dir_ / "none";
  options_.arguments = {"mapper"};
  ProgramResult result = RunProgram(options_);
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.error, HasSubstr(temp_dir_ / "none"));
  options_.arguments = {"help"};
  result = RunProgram(options_);
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.out, HasSubstr("structnerf_dense"));
}

TEST_F(LauncherTest, RealStockColmapAnswers) {
  options_.arguments = {"model_analyzer", "-h"};
  const ProgramResult result = RunProgram(options_);
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.out + result.error, HasSubstr("--path"));
}

TEST_F(LauncherTest, PrintsVersionAndOptionsWithoutWork) {
  options_.arguments = {"version"};
  EXPECT_THAT(RunProgram(options_).out, HasSubstr("COLMAP"));
  options_.arguments = {"structnerf_dense",
                        "--StructNeRF.quality",
                        "low",
                        "--StructNeRF.num_steps=77",
                        "--StructNeRF.print_options"};
  const ProgramResult result = RunProgram(options_);
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.out, HasSubstr("StructNeRF.quality = low\n"));
  EXPECT_THAT(result.out, HasSubstr("StructNeRF.num_steps = 77\n"));
}

TEST_F(LauncherTest, MethodsAreDefaultsThatOptionsOverride) {
  options_.arguments = {"structnerf_dense",
                        "--StructNeRF.method=dsnerf",
                        "--StructNeRF.sparse_form=kl",
                        "--StructNeRF.print_options"};
  const ProgramResult result = RunProgram(options_);
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.out, HasSubstr("StructNeRF.method = dsnerf\n"));
  EXPECT_THAT(result.out, HasSubstr("StructNeRF.patch_weight = 0\n"));
  EXPECT_THAT(result.out, HasSubstr("StructNeRF.sparse_fraction = 1\n"));
  EXPECT_THAT(result.out, HasSubstr("StructNeRF.sparse_form = kl\n"));
}

}  // namespace
}  // namespace structnerf
