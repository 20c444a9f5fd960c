#include "colmap_plugin/evaluation/workspace_maps.h"

#include "colmap_plugin/colmap_compat.h"

#include <algorithm>
#include <filesystem>

namespace structnerf {

namespace fs = std::filesystem;

WorkspaceMaps::WorkspaceMaps(const DenseWorkspace& workspace,
                             const colmap::Reconstruction& model,
                             const MapType type)
    : workspace_(workspace), type_(type) {
  for (const colmap::image_t image_id : RegisteredImageIds(model)) {
    const colmap::Image& image = model.Image(image_id);
    cameras_.emplace(image.Name(), model.Camera(image.CameraId()));
  }
}

bool WorkspaceMaps::HasAny() const {
  return std::any_of(cameras_.begin(), cameras_.end(), [&](const auto& entry) {
    return fs::exists(workspace_.DepthMapPath(entry.first, type_));
  });
}

std::optional<PredictedDepth> WorkspaceMaps::Find(
    const std::string& name) const {
  const auto camera = cameras_.find(name);
  const std::string path = workspace_.DepthMapPath(name, type_);
  if (camera == cameras_.end() || !fs::exists(path)) {
    return std::nullopt;
  }
  StereoMaps maps = ReadDepthMap(path);
  return PredictedDepth{
      camera->second,
      cv::Mat1f(maps.height, maps.width, maps.depth.data()).clone()};
}

}  // namespace structnerf
