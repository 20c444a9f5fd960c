#include "colmap_plugin/evaluation/workspace_maps.h"

#include "colmap_plugin/input_check.h"
#include "colmap_plugin/scene_converter.h"

#include <algorithm>
#include <filesystem>
#include <stdexcept>

namespace structnerf {

namespace fs = std::filesystem;

WorkspaceMaps::WorkspaceMaps(const std::string& path, const MapType wanted)
    : workspace_(path),
      model_(ReadModel(workspace_.SparsePath())),
      views_(ConvertGeometry(model_).views),
      type_(wanted) {
  for (size_t i = 0; i < views_.size(); ++i) {
    view_idxs_.emplace(views_[i].name, i);
  }
  if (!HasMaps(wanted)) {
    type_ = wanted == MapType::kGeometric ? MapType::kPhotometric
                                          : MapType::kGeometric;
  }
  if (!HasMaps(type_)) {
    throw std::runtime_error("The workspace " + path + " has no depth maps.");
  }
}

const View* WorkspaceMaps::FindView(const std::string& name) const {
  const auto found = view_idxs_.find(name);
  return found == view_idxs_.end() ? nullptr : &views_[found->second];
}

const colmap::Camera& WorkspaceMaps::Camera(const std::string& name) const {
  return model_.Camera(model_.FindImageWithName(name)->CameraId());
}

cv::Mat1f WorkspaceMaps::Depth(const std::string& name) const {
  if (!fs::exists(workspace_.DepthMapPath(name, type_))) {
    return cv::Mat1f();
  }
  StereoMaps maps = ReadDepthMap(workspace_.DepthMapPath(name, type_));
  return cv::Mat1f(maps.height, maps.width, maps.depth.data()).clone();
}

StereoMaps WorkspaceMaps::DepthAndNormals(const std::string& name) const {
  if (!fs::exists(workspace_.DepthMapPath(name, type_)) ||
      !fs::exists(workspace_.NormalMapPath(name, type_))) {
    return StereoMaps();
  }
  return workspace_.ReadMaps(name, type_);
}

bool WorkspaceMaps::HasMaps(const MapType type) const {
  return std::any_of(views_.begin(), views_.end(), [&](const View& view) {
    return fs::exists(workspace_.DepthMapPath(view.name, type));
  });
}

}  // namespace structnerf
