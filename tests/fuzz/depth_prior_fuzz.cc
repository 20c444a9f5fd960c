// The loading of depth priors from maps in COLMAP's format, with any bytes in
// the file.

#include "colmap_plugin/dense_workspace.h"
#include "colmap_plugin/depth_priors.h"
#include "tests/fuzz/fuzz_target.h"
#include "tests/support/temp_dir.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <filesystem>

namespace structnerf {
namespace {

constexpr const char* kName = "a.png";
constexpr int kWidth = 8;
constexpr int kHeight = 6;

const DenseWorkspace& Workspace() {
  static const TempDir folder;
  static const DenseWorkspace workspace = [] {
    DenseWorkspace created(folder / "workspace");
    created.CreateFolders({kName});
    return created;
  }();
  return workspace;
}

std::string MapPath() {
  return Workspace().DepthMapPath(kName, MapType::kGeometric);
}

// One view that is trained on at half its size.
Scene MakeScene() {
  Scene scene;
  View& view = scene.views.emplace_back();
  view.name = kName;
  view.camera = {kWidth, kHeight, 10, 10, 4, 3};
  view.image = {kWidth / 2,
                kHeight / 2,
                std::vector<uint8_t>(3 * (kWidth / 2) * (kHeight / 2), 0)};
  return scene;
}

}  // namespace

std::vector<std::string> FuzzSeeds() {
  std::vector<std::string> seeds;
  for (const int divisor : {1, 2}) {
    StereoMaps maps;
    maps.width = kWidth / divisor;
    maps.height = kHeight / divisor;
    maps.depth.assign(maps.width * maps.height, 1.5f);
    maps.normal.assign(3 * maps.depth.size(), 0.5f);
    Workspace().WriteMaps(kName, MapType::kGeometric, maps);
    seeds.push_back(ReadFuzzFile(MapPath()));
  }
  return seeds;
}

}  // namespace structnerf

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, const size_t size) {
  using namespace structnerf;
  WriteFuzzFile(MapPath(), data, size);
  Scene scene = MakeScene();
  const std::vector<float>& depths = scene.views[0].prior_depth;
  try {
    LoadDepthPriors(std::filesystem::path(MapPath()).parent_path().string(),
                    "geometric",
                    &scene);
  } catch (const std::exception&) {
    if (!depths.empty()) {
      FuzzFault("a map that was refused has left a prior");
    }
    return 0;
  }
  if (depths.size() != static_cast<size_t>(kWidth / 2) * (kHeight / 2)) {
    FuzzFault("a prior has another size than its image");
  }
  if (!std::all_of(depths.begin(), depths.end(), [](const float depth) {
        return std::isfinite(depth) && depth >= 0;
      })) {
    FuzzFault("a prior is no depth");
  }
  return 0;
}
