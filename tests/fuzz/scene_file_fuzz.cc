// The reader of scene files. An input that is accepted must be the file that
// writing what was read gives. The checksum would keep changes from what is
// behind it, so every input is also read with one that is right.

#include "nerf/scene_file.h"
#include "nerf/util/checksummed_file.h"
#include "tests/fuzz/fuzz_target.h"
#include "tests/nerf/plane_scene.h"
#include "tests/support/temp_dir.h"

#include <cstring>
#include <exception>

namespace structnerf {
namespace {

const TempDir& Folder() {
  static const TempDir folder;
  return folder;
}

void TryToRead(const std::string& bytes) {
  const std::string path = Folder() / "scene.bin";
  WriteFuzzFile(
      path, reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size());
  Scene scene;
  try {
    scene = ReadScene(path);
  } catch (const std::exception&) {
    return;
  }
  const std::string again = Folder() / "again.bin";
  WriteScene(scene, again);
  if (ReadFuzzFile(again) != bytes) {
    FuzzFault("a changed scene was taken for a good one");
  }
}

}  // namespace

std::vector<std::string> FuzzSeeds() {
  Scene scene;
  View view = MakeView("a.jpg", MakeCamera(4, 4, 5), {0, 0, 0});
  view.image = PlainImage(2, 2, 9);
  view.mask.assign(4, 255);
  view.segments.assign(4, 0);
  view.prior_depth.assign(4, 1.0f);
  scene.views = {view, view};
  scene.points = {MakePoint(scene, {0, 0, 4}, {0, 1})};
  const std::string path = Folder() / "seed.bin";
  WriteScene(scene, path);
  return {ReadFuzzFile(path)};
}

}  // namespace structnerf

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, const size_t size) {
  using namespace structnerf;
  std::string bytes(reinterpret_cast<const char*>(data), size);
  TryToRead(bytes);
  uint64_t value = 0;
  if (size >= sizeof(value)) {
    Checksum checksum;
    checksum.Add(bytes.data(), size - sizeof(value));
    value = checksum.Value();
    std::memcpy(bytes.data() + size - sizeof(value), &value, sizeof(value));
    TryToRead(bytes);
  }
  return 0;
}
