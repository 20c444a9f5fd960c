// The reader of depth and normal maps. The first byte tells where the depth map
// ends and the normal map begins.

#include "colmap_plugin/dense_workspace.h"
#include "tests/fuzz/fuzz_target.h"
#include "tests/support/temp_dir.h"

#include <algorithm>
#include <exception>

namespace structnerf {
namespace {

constexpr const char* kName = "a.png";

const TempDir& Folder() {
  static const TempDir folder;
  return folder;
}

const DenseWorkspace& Workspace() {
  static const DenseWorkspace workspace = [] {
    DenseWorkspace created(Folder() / "workspace");
    created.CreateFolders({kName});
    return created;
  }();
  return workspace;
}

}  // namespace

std::vector<std::string> FuzzSeeds() {
  std::vector<std::string> seeds;
  for (const int width : {1, 3}) {
    StereoMaps maps;
    maps.width = width;
    maps.height = 2;
    maps.depth.assign(2 * width, 1.5f);
    maps.normal.assign(6 * width, 0.5f);
    Workspace().WriteMaps(kName, MapType::kPhotometric, maps);
    const std::string depth =
        ReadFuzzFile(Workspace().DepthMapPath(kName, MapType::kPhotometric));
    const std::string normal =
        ReadFuzzFile(Workspace().NormalMapPath(kName, MapType::kPhotometric));
    seeds.push_back(static_cast<char>(depth.size()) + depth + normal);
  }
  return seeds;
}

}  // namespace structnerf

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, const size_t size) {
  using namespace structnerf;
  if (size == 0) {
    return 0;
  }
  const size_t depth_size = std::min<size_t>(data[0], size - 1);
  WriteFuzzFile(Workspace().DepthMapPath(kName, MapType::kPhotometric),
                data + 1,
                depth_size);
  WriteFuzzFile(Workspace().NormalMapPath(kName, MapType::kPhotometric),
                data + 1 + depth_size,
                size - 1 - depth_size);
  try {
    const StereoMaps maps = Workspace().ReadMaps(kName, MapType::kPhotometric);
    const bool has_size = maps.width > 0 && maps.height > 0;
    const size_t num_pixels =
        static_cast<size_t>(maps.width) * static_cast<size_t>(maps.height);
    if (!has_size || maps.depth.size() != num_pixels ||
        maps.normal.size() != 3 * num_pixels) {
      FuzzFault("maps have another size than they say");
    }
  } catch (const std::exception&) {
  }
  return 0;
}
