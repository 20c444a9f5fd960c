// The reader of poses for structnerf_render: every pose that is accepted has a
// name of its own, a rotation and a place.

#include "colmap_plugin/rendering/novel_path.h"
#include "tests/fuzz/fuzz_target.h"
#include "tests/support/temp_dir.h"

#include <exception>
#include <set>
#include <string>
#include <vector>

namespace structnerf {
namespace {

const TempDir& Folder() {
  static const TempDir folder;
  return folder;
}

}  // namespace

std::vector<std::string> FuzzSeeds() {
  return {"# comment\n\na 1 0 0 0 1 2 3\nsub/b 0 0 -1 0 0 0 -1e3\r\n",
          "a 0.5 0.5 0.5 0.5 0 0 0\nb 0.7071068 0 0.7071068 0 1e-300 0 1e300"};
}

}  // namespace structnerf

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, const size_t size) {
  using namespace structnerf;
  const std::string path = Folder() / "poses.txt";
  WriteFuzzFile(path, data, size);
  std::vector<View> views;
  try {
    views = ReadPoses(path, {64, 48, 60, 60, 32, 24});
  } catch (const std::exception& error) {
    if (std::string(error.what()).find(path) == std::string::npos) {
      FuzzFault("the file is not named");
    }
    return 0;
  }
  std::set<std::string> names;
  for (const View& view : views) {
    if (view.name.empty() || !names.insert(view.name).second) {
      FuzzFault("a name is missing or there twice");
    }
    if (!view.cam_from_world_rotation.isUnitary(1e-9) ||
        !view.cam_from_world_translation.allFinite()) {
      FuzzFault("a pose is none");
    }
  }
  if (views.empty()) {
    FuzzFault("a file without poses was accepted");
  }
  return 0;
}
