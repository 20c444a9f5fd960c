// The list of files that a run was moving when it was killed, with any bytes in
// it: what lies outside of the output folder must stay as it is, and what was
// replaced must not be lost.

#include "colmap_plugin/staged_folder.h"
#include "tests/fuzz/fuzz_target.h"
#include "tests/support/temp_dir.h"

#include <exception>
#include <filesystem>
#include <set>
#include <string>

namespace structnerf {
namespace {

namespace fs = std::filesystem;

constexpr char kHiddenName[] = "in/out/.structnerf-partial";
constexpr char kReplaced[] = "replaced";

const TempDir& Folder() {
  static const TempDir folder;
  return folder;
}

void WriteText(const std::string& path, const std::string& text) {
  fs::create_directories(fs::path(path).parent_path());
  WriteFuzzFile(
      path, reinterpret_cast<const uint8_t*>(text.data()), text.size());
}

// Everything but what is in the output folder.
std::set<std::string> ListOutside() {
  std::set<std::string> paths;
  for (auto it = fs::recursive_directory_iterator(Folder().Path());
       it != fs::recursive_directory_iterator();
       ++it) {
    paths.insert(it->path().string());
    if (it->path() == Folder() / "in/out") {
      it.disable_recursion_pending();
    }
  }
  return paths;
}

// Wherever they are now.
int CountReplaced() {
  int count = 0;
  for (const auto& entry :
       fs::recursive_directory_iterator(Folder() / "in/out")) {
    count += entry.is_regular_file() &&
             ReadFuzzFile(entry.path().string()) == kReplaced;
  }
  return count;
}

}  // namespace

std::vector<std::string> FuzzSeeds() {
  const std::string zero(1, '\0');
  return {"a" + zero + "deep/er/b" + zero + "c" + zero,
          "../../a" + zero + "../a" + zero + "deep/../../../empty/c" + zero,
          (Folder() / "a") + zero + (Folder() / "empty/c") + zero,
          "./" + zero + "/" + zero + zero + "a"};
}

}  // namespace structnerf

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, const size_t size) {
  using namespace structnerf;
  fs::remove_all(Folder() / "in");
  WriteText(Folder() / "a", "outside");
  WriteText(Folder() / "in/a", "outside");
  fs::create_directories(Folder() / "empty");
  WriteText(Folder() / "in/out/a", "moved");
  WriteText(Folder() / "in/out/deep/er/b", "moved");
  const std::string hidden = Folder() / kHiddenName;
  WriteText(hidden + "/.resume/replaced/deep/er/b", kReplaced);
  WriteText(hidden + "/.resume/replaced/c", kReplaced);
  WriteFuzzFile(hidden + "/.resume/commit", data, size);
  const std::set<std::string> before = ListOutside();
  try {
    StagedFolder::UndoCommit(Folder() / "in/out");
  } catch (const std::exception&) {
  }
  if (CountReplaced() != 2) {
    FuzzFault("undoing has lost a file that was replaced");
  }
  if (ListOutside() != before || ReadFuzzFile(Folder() / "a") != "outside" ||
      ReadFuzzFile(Folder() / "in/a") != "outside") {
    FuzzFault("undoing has reached out of the folder");
  }
  return 0;
}
