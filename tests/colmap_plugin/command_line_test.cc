#include "colmap_plugin/command_line.h"

#include "tests/support/temp_dir.h"

#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace structnerf {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

std::vector<std::string> Expand(const std::vector<std::string>& args) {
  return ExpandCommandLine(
      args, {"StructNeRF.", "StereoFusion.", "image_path"}, {"overwrite"});
}

TEST(CommandLine, LeavesOrdinaryOptionsAlone) {
  EXPECT_THAT(Expand({"colmap", "--image_path", "a b", "--x=1", "-h"}),
              ElementsAre("colmap", "--image_path", "a b", "--x=1", "-h"));
}

TEST(CommandLine, FlagsMayStandAlone) {
  EXPECT_THAT(Expand({"colmap", "--overwrite"}),
              ElementsAre("colmap", "--overwrite=1"));
  EXPECT_THAT(Expand({"colmap", "--overwrite", "--image_path", "a"}),
              ElementsAre("colmap", "--overwrite=1", "--image_path", "a"));
  EXPECT_THAT(Expand({"colmap", "--overwrite", "0"}),
              ElementsAre("colmap", "--overwrite", "0"));
  EXPECT_THAT(Expand({"colmap", "--overwrite=0"}),
              ElementsAre("colmap", "--overwrite=0"));
}

TEST(CommandLine, NamesArgumentWithoutOption) {
  for (const std::vector<std::string>& args :
       {std::vector<std::string>{"colmap", "stray"},
        {"colmap", "--image_path", "my", "stray"},
        {"colmap", "--image_path=my", "stray"}}) {
    try {
      Expand(args);
      FAIL();
    } catch (const std::runtime_error& error) {
      EXPECT_THAT(error.what(), HasSubstr("\"stray\""));
    }
  }
  EXPECT_NO_THROW(Expand({"colmap", "--StructNeRF.num_threads", "-1"}));
}

class ProjectFileTest : public testing::Test {
 protected:
  ProjectFileTest() : path_(temp_dir_ / "project.ini") {}

  TempDir temp_dir_;
  const std::string path_;
};

TEST_F(ProjectFileTest, TakesOurKeysAndIgnoresOtherCommands) {
  std::ofstream(path_) << "log_level=1\n"
                          "database_path=/some/database.db\n"
                          "image_path=/my images\n"
                          "[SiftExtraction]\n"
                          "num_threads=3\n"
                          "[StereoFusion]\n"
                          "mask_path=\n"
                          "min_num_pixels=4\n"
                          "[StructNeRF]\n"
                          "num_steps=10\n";
  EXPECT_THAT(Expand({"colmap", "--project_path", path_}),
              ElementsAre("colmap",
                          "--image_path=/my images",
                          "--StereoFusion.min_num_pixels=4",
                          "--StructNeRF.num_steps=10"));
}

TEST_F(ProjectFileTest, SectionsThatACommandDoesNotKnowAreIgnored) {
  std::ofstream(path_) << "image_path=a\n[StereoFusion]\nmin_num_pixels=4\n";
  EXPECT_THAT(ExpandCommandLine(
                  {"colmap", "--project_path", path_}, {"image_path"}, {}),
              ElementsAre("colmap", "--image_path=a"));
}

TEST_F(ProjectFileTest, CommandLineWins) {
  std::ofstream(path_) << "image_path=a\n[StructNeRF]\nseed=1\nnum_steps=2\n";
  EXPECT_THAT(Expand({"colmap",
                      "--StructNeRF.seed=3",
                      "--project_path=" + path_,
                      "--image_path",
                      "b"}),
              ElementsAre("colmap",
                          "--StructNeRF.num_steps=2",
                          "--StructNeRF.seed=3",
                          "--image_path",
                          "b"));
}

TEST_F(ProjectFileTest, NamesFileThatCannotBeRead) {
  try {
    Expand({"colmap", "--project_path", path_});
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr(path_));
  }
  std::ofstream(path_) << "no key and value\n";
  EXPECT_THROW(Expand({"colmap", "--project_path", path_}), std::runtime_error);
}

TEST(FindOption, KnowsBothFormsAndTakesTheLast) {
  const std::vector<std::string> args = {
      "colmap", "--quality", "low", "--quality=high", "--quality_x=other"};
  EXPECT_EQ(FindOption(args, "quality", "medium"), "high");
  EXPECT_EQ(FindOption(args, "qual", "medium"), "medium");
  EXPECT_EQ(FindOption({"colmap", "--quality"}, "quality", "medium"), "medium");
}

}  // namespace
}  // namespace structnerf
