// The journal of files that are complete, with any bytes in it: it may forget
// files, but must not take a damaged one for whole, and goes on being written.

#include "colmap_plugin/file_journal.h"
#include "tests/fuzz/fuzz_target.h"
#include "tests/support/temp_dir.h"

#include <filesystem>
#include <string>

namespace structnerf {
namespace {

constexpr char kKey[] = "key";

const TempDir& Folder() {
  static const TempDir folder;
  return folder;
}

std::string JournalPath() { return Folder() / "journal"; }

void WriteText(const std::string& path, const std::string& text) {
  WriteFuzzFile(
      path, reinterpret_cast<const uint8_t*>(text.data()), text.size());
}

FileJournal OpenJournal() {
  return FileJournal(JournalPath(), Folder().Path().string(), kKey);
}

}  // namespace

std::vector<std::string> FuzzSeeds() {
  for (const char* name : {"a", "b c"}) {
    WriteText(Folder() / name, "whole");
    OpenJournal().Add(Folder() / name);
  }
  const std::string journal = ReadFuzzFile(JournalPath());
  return {journal, journal + journal, journal.substr(0, journal.size() - 4)};
}

}  // namespace structnerf

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, const size_t size) {
  using namespace structnerf;
  // A journal cannot know this file, whatever it says of its namesake.
  static const std::string damaged = Folder() / "damaged";
  WriteText(damaged, "neither whole nor short");
  WriteFuzzFile(JournalPath(), data, size);
  if (OpenJournal().IsIntact(damaged)) {
    FuzzFault("a file counts as whole that was never added");
  }
  WriteText(Folder() / "new", "whole");
  OpenJournal().Add(Folder() / "new");
  if (!OpenJournal().IsIntact(Folder() / "new")) {
    FuzzFault("a file that was added is forgotten");
  }
  WriteText(Folder() / "new", "whOle");
  if (OpenJournal().IsIntact(Folder() / "new")) {
    FuzzFault("a damaged file counts as whole");
  }
  return 0;
}
