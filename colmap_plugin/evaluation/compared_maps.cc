#include "colmap_plugin/evaluation/compared_maps.h"

#include "colmap_plugin/input_check.h"
#include "colmap_plugin/scene_converter.h"

#include <filesystem>
#include <stdexcept>

namespace structnerf {

ComparedMaps::ComparedMaps(const std::string& workspace_path)
    : workspace_(workspace_path),
      model_(ReadModel(workspace_.SparsePath())),
      photometric_(workspace_, model_, MapType::kPhotometric),
      geometric_(workspace_, model_, MapType::kGeometric),
      views_(ConvertGeometry(model_).views) {
  if (!Has(MapType::kPhotometric) && !Has(MapType::kGeometric)) {
    throw std::runtime_error("The workspace " + workspace_path +
                             " has no depth maps; run patch_match_stereo or "
                             "structnerf_dense on it.");
  }
  for (size_t i = 0; i < views_.size(); ++i) {
    view_idxs_.emplace(views_[i].name, i);
  }
}

const View* ComparedMaps::FindView(const std::string& name) const {
  const auto found = view_idxs_.find(name);
  return found == view_idxs_.end() ? nullptr : &views_[found->second];
}

bool ComparedMaps::Has(const MapType type) const {
  return MapsOf(type).HasAny();
}

std::optional<PredictedDepth> ComparedMaps::Depth(const std::string& name,
                                                  const MapType type) const {
  return MapsOf(type).Find(name);
}

std::optional<StereoMaps> ComparedMaps::DepthAndNormals(
    const std::string& name, const MapType type) const {
  if (!std::filesystem::exists(workspace_.DepthMapPath(name, type)) ||
      !std::filesystem::exists(workspace_.NormalMapPath(name, type))) {
    return std::nullopt;
  }
  return workspace_.ReadMaps(name, type);
}

const WorkspaceMaps& ComparedMaps::MapsOf(const MapType type) const {
  return type == MapType::kPhotometric ? photometric_ : geometric_;
}

}  // namespace structnerf
