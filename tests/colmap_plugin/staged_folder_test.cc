#include "colmap_plugin/staged_folder.h"

#include "tests/support/temp_dir.h"
#include "tests/support/text_file.h"

#include <cerrno>
#include <cstddef>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <unistd.h>

namespace structnerf {
namespace {

namespace fs = std::filesystem;

using testing::HasSubstr;

void WriteText(const std::string& path, const std::string& text) {
  fs::create_directories(fs::path(path).parent_path());
  std::ofstream(path) << text;
}

std::string ErrorOf(const std::string& output_path) {
  try {
    StagedFolder folder(output_path, /*resume=*/false);
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
    StagedFolder folder(output, /*resume=*/false);
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
    StagedFolder folder(temp_dir / "not/yet/there", /*resume=*/false);
    WriteText(folder.Path() + "/a.bin", "a");
  }
  EXPECT_TRUE(fs::is_empty(temp_dir.Path()));

  WriteText(temp_dir / "out/mine.txt", "mine");
  { StagedFolder folder(temp_dir / "out", /*resume=*/false); }
  EXPECT_EQ(ReadText(temp_dir / "out/mine.txt"), "mine");
  EXPECT_EQ(std::distance(fs::directory_iterator(temp_dir / "out"), {}), 1);
}

TEST(StagedFolder, TrailingSlashIsNoFolder) {
  const TempDir temp_dir;
  {
    StagedFolder folder(temp_dir / "out/", /*resume=*/false);
    WriteText(folder.Path() + "/a.bin", "a");
    folder.Commit();
  }
  EXPECT_EQ(ReadText(temp_dir / "out/a.bin"), "a");
}

TEST(StagedFolder, ReplacesWhatAKilledRunLeft) {
  const TempDir temp_dir;
  std::string path;
  {
    StagedFolder folder(temp_dir / "out", /*resume=*/false);
    path = folder.Path();
  }
  WriteText(path + "/stereo/left.bin", "left");
  StagedFolder folder(temp_dir / "out", /*resume=*/false);
  EXPECT_FALSE(fs::exists(path + "/stereo"));
}

TEST(StagedFolder, KeepsWhatAnotherRunGoesOnFrom) {
  const TempDir temp_dir;
  const std::string output = temp_dir / "new/out";
  {
    StagedFolder folder(output, /*resume=*/true);
    WriteText(folder.Path() + "/a.bin", "a");
    WriteText(folder.NotesPath() + "/note", "note");
    folder.Keep();
  }
  EXPECT_EQ(StagedFolder::NumBytesLeft(output), 5u);
  {
    StagedFolder folder(output, /*resume=*/true);
    EXPECT_EQ(ReadText(folder.Path() + "/a.bin"), "a");
    EXPECT_EQ(ReadText(folder.NotesPath() + "/note"), "note");
    folder.Commit();
  }
  // The notes are of no use any more.
  EXPECT_EQ(ReadText(output + "/a.bin"), "a");
  EXPECT_EQ(std::distance(fs::directory_iterator(output), {}), 1);
  EXPECT_EQ(StagedFolder::NumBytesLeft(output), 0u);
}

TEST(StagedFolder, ClearsAllButTheFolders) {
  const TempDir temp_dir;
  StagedFolder folder(temp_dir / "out", /*resume=*/true);
  WriteText(folder.Path() + "/stereo/a.bin", "a");
  WriteText(folder.NotesPath() + "/note", "note");
  folder.Clear();
  EXPECT_EQ(StagedFolder::NumBytesLeft(temp_dir / "out"), 0u);
  EXPECT_TRUE(fs::is_empty(folder.NotesPath()));
  EXPECT_THAT(ErrorOf(temp_dir / "out"), HasSubstr("Another run"));
}

// Every moment at which a run can be killed while it moves its files: so many
// renames are done, the next is not. Two of the three files replace old ones.
TEST(StagedFolder, UndoesACommitThatWasKilled) {
  for (int num_renames = 0; num_renames <= 5; ++num_renames) {
    const TempDir temp_dir;
    const std::string output = temp_dir / "out";
    const std::vector<std::string> names = {"a.bin", "deep/er/b.bin", "c.bin"};
    std::string path;
    {
      StagedFolder folder(output, /*resume=*/true);
      path = folder.Path();
      std::ofstream list(folder.NotesPath() + "/commit", std::ios::binary);
      int num_left = num_renames;
      for (const std::string& name : names) {
        if (name != "c.bin") {
          const bool is_aside = num_left-- > 0;
          WriteText((is_aside ? folder.NotesPath() + "/replaced" : output) +
                        "/" + name,
                    "old");
        }
        const bool is_moved = num_left-- > 0;
        WriteText((is_moved ? output : path) + "/" + name, name);
        list << name << '\0';
      }
      folder.Keep();
    }
    WriteText(output + "/mine.txt", "mine");
    StagedFolder::UndoCommit(output);
    StagedFolder::UndoCommit(output);
    for (const std::string& name : names) {
      EXPECT_EQ(ReadText(path + "/" + name), name);
    }
    EXPECT_EQ(ReadText(output + "/a.bin"), "old");
    EXPECT_EQ(ReadText(output + "/deep/er/b.bin"), "old");
    EXPECT_FALSE(fs::exists(output + "/c.bin"));
    EXPECT_EQ(ReadText(output + "/mine.txt"), "mine");
    StagedFolder folder(output, /*resume=*/true);
    folder.Commit();
    EXPECT_EQ(ReadText(output + "/deep/er/b.bin"), "deep/er/b.bin");
  }
}

TEST(StagedFolder, UndoingRemovesFoldersThatWereMade) {
  const TempDir temp_dir;
  const std::string output = temp_dir / "out";
  {
    StagedFolder folder(output, /*resume=*/true);
    std::ofstream(folder.NotesPath() + "/commit", std::ios::binary)
        << "deep/er/b.bin" << '\0' << "deep/" << '\0' << "deep/er/" << '\0';
    WriteText(output + "/deep/er/b.bin", "b");
    folder.Keep();
  }
  StagedFolder::UndoCommit(output);
  EXPECT_FALSE(fs::exists(output + "/deep"));
}

// COLMAP's tools write into folders that they do not make.
TEST(StagedFolder, UndoingLeavesFoldersThatWereThere) {
  for (const std::string blocked : {"a.bin", "z.bin"}) {
    const TempDir temp_dir;
    const std::string output = temp_dir / "out";
    fs::create_directories(output + "/stereo/depth_maps");
    WriteText(output + "/" + blocked + "/file", "in the way");
    StagedFolder folder(output, /*resume=*/true);
    WriteText(folder.Path() + "/" + blocked, "new");
    WriteText(folder.Path() + "/stereo/depth_maps/sub/m.bin", "m");
    WriteText(folder.Path() + "/made/n.bin", "n");
    EXPECT_THROW(folder.Commit(), std::runtime_error);
    EXPECT_TRUE(fs::is_empty(output + "/stereo/depth_maps"));
    EXPECT_FALSE(fs::exists(output + "/made"));
  }
}

// What a run that was killed has replaced is no business of the next.
TEST(StagedFolder, UndoingBringsBackNoOlderFiles) {
  const TempDir temp_dir;
  const std::string output = temp_dir / "out";
  WriteText(output + "/b.bin/file", "in the way");
  StagedFolder folder(output, /*resume=*/true);
  WriteText(folder.NotesPath() + "/replaced/a.bin", "older");
  WriteText(folder.Path() + "/a.bin", "a");
  WriteText(folder.Path() + "/b.bin", "b");
  EXPECT_THROW(folder.Commit(), std::runtime_error);
  EXPECT_FALSE(fs::exists(output + "/a.bin"));
}

// Not even if somebody else has written the list.
TEST(StagedFolder, UndoingMovesNothingFromOutside) {
  const TempDir temp_dir;
  const std::string output = temp_dir / "in/out";
  WriteText(temp_dir / "precious", "precious");
  fs::create_directory(temp_dir / "empty");
  {
    StagedFolder folder(output, /*resume=*/true);
    std::ofstream(folder.NotesPath() + "/commit", std::ios::binary)
        << "../../precious" << '\0' << temp_dir / "empty/file" << '\0'
        << "../stray" << '\0';
    // Where a replaced file of that name would be.
    WriteText(folder.NotesPath() + "/stray", "stray");
    folder.Keep();
  }
  StagedFolder::UndoCommit(output);
  EXPECT_EQ(ReadText(temp_dir / "precious"), "precious");
  EXPECT_TRUE(fs::exists(temp_dir / "empty"));
  EXPECT_FALSE(fs::exists(temp_dir / "in/precious"));
  EXPECT_FALSE(fs::exists(temp_dir / "in/stray"));
}

// One file cannot be moved to where a folder is; whichever the order, files
// before it replace old ones.
TEST(StagedFolder, ACommitThatFailsIsUndone) {
  const std::vector<std::string> names = {"a.bin", "b.bin", "c.bin"};
  for (const std::string& blocked : names) {
    const TempDir temp_dir;
    const std::string output = temp_dir / "out";
    for (const std::string& name : names) {
      WriteText(output + "/" + name + (name == blocked ? "/file" : ""), "old");
    }
    StagedFolder folder(output, /*resume=*/true);
    for (const std::string& name : names) {
      WriteText(folder.Path() + "/" + name, name);
    }
    EXPECT_THROW(folder.Commit(), std::runtime_error);
    for (const std::string& name : names) {
      EXPECT_EQ(ReadText(folder.Path() + "/" + name), name);
      EXPECT_EQ(
          ReadText(output + "/" + name + (name == blocked ? "/file" : "")),
          "old");
    }
    EXPECT_EQ(std::distance(fs::directory_iterator(output), {}), 4);
  }
}

TEST(StagedFolder, ACommitInProgressIsNotUndone) {
  const TempDir temp_dir;
  StagedFolder folder(temp_dir / "out", /*resume=*/true);
  WriteText(temp_dir / "out/a.bin", "a");
  std::ofstream(folder.NotesPath() + "/commit", std::ios::binary)
      << "a.bin" << '\0';
  StagedFolder::UndoCommit(temp_dir / "out");
  EXPECT_EQ(ReadText(temp_dir / "out/a.bin"), "a");
}

TEST(StagedFolder, RefusesASecondRun) {
  const TempDir temp_dir;
  StagedFolder folder(temp_dir / "out", /*resume=*/false);
  WriteText(folder.Path() + "/a.bin", "a");
  EXPECT_THAT(ErrorOf(temp_dir / "out"), HasSubstr("Another run"));
  EXPECT_EQ(ReadText(folder.Path() + "/a.bin"), "a");
  folder.Commit();
  EXPECT_EQ(ReadText(temp_dir / "out/a.bin"), "a");
}

// From now on, a system call of this process fails.
void Forbid(const long system_call, const int error) {
  sock_filter filter[] = {
      BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, nr)),
      BPF_JUMP(
          BPF_JMP | BPF_JEQ | BPF_K, static_cast<unsigned>(system_call), 0, 1),
      BPF_STMT(BPF_RET | BPF_K,
               SECCOMP_RET_ERRNO | static_cast<unsigned>(error)),
      BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW)};
  const sock_fprog program = {4, filter};
  if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0 ||
      prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program) != 0) {
    std::cerr << "no filters here";
    std::exit(2);
  }
}

TEST(StagedFolder, WritesWhereThereAreNoLocks) {
  const TempDir temp_dir;
  EXPECT_EXIT(
      {
        Forbid(SYS_flock, ENOSYS);
        StagedFolder folder(temp_dir / "out", /*resume=*/false);
        WriteText(folder.Path() + "/a.bin", "a");
        folder.Commit();
        std::exit(ReadText(temp_dir / "out/a.bin") == "a" ? 0 : 1);
      },
      testing::ExitedWithCode(0),
      "");
}

TEST(StagedFolder, SaysWhetherItCanLink) {
  const TempDir temp_dir;
  const StagedFolder folder(temp_dir / "out", /*resume=*/false);
  EXPECT_TRUE(folder.CanLink());
  EXPECT_TRUE(folder.CanLink());
  EXPECT_EXIT(
      {
        Forbid(SYS_symlink, EPERM);
        std::exit(folder.CanLink() ? 1 : 0);
      },
      testing::ExitedWithCode(0),
      "");
}

TEST(StagedFolder, DoesNotMoveLinks) {
  const TempDir temp_dir;
  WriteText(temp_dir / "images/a.png", "a");
  {
    StagedFolder folder(temp_dir / "out", /*resume=*/false);
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
