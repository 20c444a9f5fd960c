#include "colmap_plugin/centred_workspace.h"

#include "colmap_plugin/colmap_compat.h"
#include "colmap_plugin/input_check.h"
#include "nerf/util/median.h"

#include <filesystem>
#include <map>
#include <numeric>
#include <stdexcept>

#include <colmap/geometry/sim3.h>

namespace structnerf {
namespace {

namespace fs = std::filesystem;

// Distances from the origin, in sizes of the scene, that single precision
// affords: 1e-5 of the size is lost.
constexpr double kMaxDistance = 100;

// Where the model must be moved to be around the origin; zero if it is near
// enough.
Eigen::Vector3d FindOffset(const colmap::Reconstruction& reconstruction) {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  const auto image_ids = RegisteredImageIds(reconstruction);
  for (const colmap::image_t image_id : image_ids) {
    center += reconstruction.Image(image_id).ProjectionCenter() /
              static_cast<double>(image_ids.size());
  }
  std::vector<double> distances;
  for (const auto& [point3D_id, point3D] : reconstruction.Points3D()) {
    distances.push_back((point3D.xyz - center).norm());
  }
  if (distances.empty()) {
    return Eigen::Vector3d::Zero();
  }
  return center.norm() > kMaxDistance * Median(&distances)
             ? center
             : Eigen::Vector3d::Zero();
}

}  // namespace

bool CentredWorkspace::IsNeeded(const colmap::Reconstruction& reconstruction) {
  return !FindOffset(reconstruction).isZero(0);
}

CentredWorkspace::CentredWorkspace(const DenseWorkspace& workspace)
    : path_(workspace.Path()) {
  colmap::Reconstruction reconstruction = ReadModel(workspace.SparsePath());
  const std::vector<std::string> names = ImageNames(reconstruction);
  image_idxs_.resize(names.size());
  std::iota(image_idxs_.begin(), image_idxs_.end(), 0);
  offset_ = FindOffset(reconstruction);
  if (offset_.isZero(0)) {
    return;
  }
  reconstruction.Transform(
      colmap::Sim3d(1, Eigen::Quaterniond::Identity(), -offset_));
  folder_ = (fs::path(workspace.ReportFolder()) / "centred").string();
  const DenseWorkspace centred(folder_);
  try {
    fs::remove_all(folder_);
    fs::create_directories(centred.SparsePath());
    fs::create_directory_symlink(fs::canonical(workspace.ImagesPath()),
                                 centred.ImagesPath());
    fs::create_directory_symlink(
        fs::canonical(fs::path(workspace.Path()) / "stereo"),
        fs::path(folder_) / "stereo");
  } catch (const fs::filesystem_error& error) {
    throw std::runtime_error("The folder " + folder_ + " could not be made: " +
                             error.code().message() + ".");
  }
  reconstruction.WriteBinary(centred.SparsePath());
  path_ = folder_;

  // The file does not keep the order of the images.
  std::map<std::string, int> idxs;
  for (size_t i = 0; i < names.size(); ++i) {
    idxs[names[i]] = static_cast<int>(i);
  }
  image_idxs_.clear();
  const colmap::Reconstruction written =
      ReadWrittenModel(reconstruction, centred.SparsePath());
  for (const std::string& name : ImageNames(written)) {
    image_idxs_.push_back(idxs.at(name));
  }
}

CentredWorkspace::~CentredWorkspace() {
  if (!folder_.empty()) {
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
  }
}

}  // namespace structnerf
