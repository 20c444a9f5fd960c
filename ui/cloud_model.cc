#include "ui/cloud_model.h"

#include <filesystem>
#include <stdexcept>

#include <colmap/util/ply.h>

namespace structnerf {

std::shared_ptr<colmap::Reconstruction> MakeCloudModel(
    const colmap::Reconstruction& sparse, const std::string& ply_path) {
  if (!std::filesystem::exists(ply_path)) {
    throw std::runtime_error("The cloud " + ply_path +
                             " is not there any more.");
  }
  auto model = std::make_shared<colmap::Reconstruction>(sparse);
  for (const colmap::point3D_t point3D_id : sparse.Point3DIds()) {
    model->DeletePoint3D(point3D_id);
  }
  for (const colmap::PlyPoint& point : colmap::ReadPly(ply_path)) {
    model->AddPoint3D(Eigen::Vector3d(point.x, point.y, point.z),
                      colmap::Track(),
                      Eigen::Matrix<uint8_t, 3, 1>(point.r, point.g, point.b));
  }
  return model;
}

}  // namespace structnerf
