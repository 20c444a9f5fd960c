#include "colmap_plugin/file_journal.h"

#include "tests/support/temp_dir.h"

#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>

#include <gtest/gtest.h>

namespace structnerf {
namespace {

namespace fs = std::filesystem;

class FileJournalTest : public testing::Test {
 protected:
  FileJournalTest() : path_(folder_ / "journal") {
    Write("a", "content of a");
    Write("a folder/b", std::string(3000000, 'b'));
  }

  void Write(const std::string& name, const std::string& text) const {
    fs::create_directories(fs::path(folder_ / name).parent_path());
    std::ofstream(folder_ / name, std::ios::binary) << text;
  }

  FileJournal Open(const std::string& key = "key") const {
    return FileJournal(path_, folder_.Path(), key);
  }

  TempDir folder_;
  const std::string path_;
};

TEST_F(FileJournalTest, KnowsTheFilesAfterwards) {
  {
    FileJournal journal = Open();
    EXPECT_FALSE(journal.IsIntact(folder_ / "a"));
    journal.Add(folder_ / "a");
    EXPECT_TRUE(journal.IsIntact(folder_ / "a"));
    journal.Add(folder_ / "a folder/b");
  }
  FileJournal journal = Open();
  EXPECT_TRUE(journal.IsIntact(folder_ / "a"));
  EXPECT_TRUE(journal.IsIntact(folder_ / "a folder/b"));
  EXPECT_FALSE(journal.IsIntact(folder_ / "journal"));
}

TEST_F(FileJournalTest, ChangedFilesAreNotIntact) {
  FileJournal journal = Open();
  journal.Add(folder_ / "a");
  for (const char* text : {"content of b", "content of a ", "", "content of"}) {
    Write("a", text);
    EXPECT_FALSE(journal.IsIntact(folder_ / "a")) << text;
  }
  fs::remove(folder_ / "a");
  EXPECT_FALSE(journal.IsIntact(folder_ / "a"));
  Write("a", "new");
  journal.Add(folder_ / "a");
  EXPECT_TRUE(Open().IsIntact(folder_ / "a"));
}

TEST_F(FileJournalTest, AnotherKeyEmptiesIt) {
  Open().Add(folder_ / "a");
  EXPECT_TRUE(FileJournal::Exists(path_, "key"));
  EXPECT_FALSE(FileJournal::Exists(path_, "ke"));
  EXPECT_FALSE(FileJournal::Exists(folder_ / "none", "key"));
  EXPECT_FALSE(Open("other").IsIntact(folder_ / "a"));
  EXPECT_FALSE(Open().IsIntact(folder_ / "a"));
}

// The process can be killed while it writes.
TEST_F(FileJournalTest, TornLinesCountAsNone) {
  {
    FileJournal journal = Open();
    journal.Add(folder_ / "a folder/b");
    journal.Add(folder_ / "a");
  }
  const auto size = fs::file_size(path_);
  for (uintmax_t left = size; left-- > 0;) {
    fs::resize_file(path_, left);
    {
      FileJournal journal = Open();
      EXPECT_FALSE(journal.IsIntact(folder_ / "a")) << left;
      journal.Add(folder_ / "a");
    }
    EXPECT_TRUE(Open().IsIntact(folder_ / "a")) << left;
    if (left % 16 != 0) {
      left -= left % 16;
    }
  }
}

TEST_F(FileJournalTest, MovesWithItsFolder) {
  Open().Add(folder_ / "a");
  const TempDir other;
  fs::copy(folder_.Path(), other.Path(), fs::copy_options::recursive);
  const FileJournal journal(other / "journal", other.Path(), "key");
  EXPECT_TRUE(journal.IsIntact(other / "a"));
}

TEST_F(FileJournalTest, FilesThatCannotBeReadOrWritten) {
  EXPECT_THROW(Open().Add(folder_ / "none"), std::runtime_error);
  EXPECT_THROW(FileJournal(folder_ / "none/journal", folder_.Path(), "key"),
               std::runtime_error);
}

}  // namespace
}  // namespace structnerf
