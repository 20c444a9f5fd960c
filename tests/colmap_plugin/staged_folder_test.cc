#include "colmap_plugin/staged_folder.h"

#include "tests/support/temp_dir.h"

#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace structnerf {
namespace {

namespace fs = std::filesystem;

using testing::HasSubstr;

void WriteText(const std::string& path, const std::string& text) {
  fs::create_directories(fs::path(path).parent_path());
  std::ofstream(path) << text;
}

std::string ReadText(const std::string& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::string ErrorOf(const std::string& output_path) {
  try {
    StagedFolder folder(output_path);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

TEST(StagedFolder, CommitMovesFilesOverOldOnes) {
  const TempDir temp_dir;
  const std::string output = temp_dir / "out";
  WriteText(output + "/stereo/a.bin", "old");
  WriteText(output + "/stereo/other.bin", "kept");
  {
    StagedFolder folder(output);
    WriteText(folder.Path() + "/stereo/a.bin", "new");
    WriteText(folder.Path() + "/deep/er/b.bin", "b");
    EXPECT_EQ(ReadText(output + "/stereo/a.bin"), "old");
    EXPECT_FALSE(fs::exists(output + "/deep"));
    folder.Commit();
  }
  EXPECT_EQ(ReadText(output + "/stereo/a.bin"), "new");
  EXPECT_EQ(ReadText(output + "/stereo/other.bin"), "kept");
  EXPECT_EQ(ReadText(output + "/deep/er/b.bin"), "b");
  EXPECT_EQ(std::distance(fs::directory_iterator(output), {}), 2);
}

TEST(StagedFolder, WithoutCommitTheDiskIsAsBefore) {
  const TempDir temp_dir;
  {
    StagedFolder folder(temp_dir / "not/yet/there");
    WriteText(folder.Path() + "/a.bin", "a");
  }
  EXPECT_TRUE(fs::is_empty(temp_dir.Path()));

  WriteText(temp_dir / "out/mine.txt", "mine");
  { StagedFolder folder(temp_dir / "out"); }
  EXPECT_EQ(ReadText(temp_dir / "out/mine.txt"), "mine");
  EXPECT_EQ(std::distance(fs::directory_iterator(temp_dir / "out"), {}), 1);
}

TEST(StagedFolder, TrailingSlashIsNoFolder) {
  const TempDir temp_dir;
  {
    StagedFolder folder(temp_dir / "out/");
    WriteText(folder.Path() + "/a.bin", "a");
    folder.Commit();
  }
  EXPECT_EQ(ReadText(temp_dir / "out/a.bin"), "a");
}

TEST(StagedFolder, ReplacesWhatAKilledRunLeft) {
  const TempDir temp_dir;
  std::string path;
  {
    StagedFolder folder(temp_dir / "out");
    path = folder.Path();
  }
  WriteText(path + "/stereo/left.bin", "left");
  StagedFolder folder(temp_dir / "out");
  EXPECT_FALSE(fs::exists(path + "/stereo"));
}

TEST(StagedFolder, RefusesASecondRun) {
  const TempDir temp_dir;
  StagedFolder folder(temp_dir / "out");
  WriteText(folder.Path() + "/a.bin", "a");
  EXPECT_THAT(ErrorOf(temp_dir / "out"), HasSubstr("Another run"));
  EXPECT_EQ(ReadText(folder.Path() + "/a.bin"), "a");
  folder.Commit();
  EXPECT_EQ(ReadText(temp_dir / "out/a.bin"), "a");
}

TEST(StagedFolder, DoesNotMoveLinks) {
  const TempDir temp_dir;
  WriteText(temp_dir / "images/a.png", "a");
  {
    StagedFolder folder(temp_dir / "out");
    fs::create_directory_symlink(temp_dir / "images",
                                 folder.Path() + "/images");
    WriteText(folder.Path() + "/b.bin", "b");
    folder.Commit();
  }
  EXPECT_FALSE(fs::exists(temp_dir / "out/images"));
  EXPECT_EQ(ReadText(temp_dir / "images/a.png"), "a");
  EXPECT_EQ(ReadText(temp_dir / "out/b.bin"), "b");
}

TEST(StagedFolder, NamesFolderThatCannotBeWritten) {
  const TempDir temp_dir;
  WriteText(temp_dir / "file", "file");
  EXPECT_THAT(ErrorOf(temp_dir / "file/out"), HasSubstr(temp_dir / "file/out"));
  EXPECT_THAT(ErrorOf(temp_dir / "file"), HasSubstr("cannot be written"));
  // Nobody, not even root, creates files there.
  EXPECT_THAT(ErrorOf("/proc/out"), HasSubstr("cannot be written"));
}

}  // namespace
}  // namespace structnerf
