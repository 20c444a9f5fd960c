#include "ui/cloud_model.h"

#include "colmap_plugin/evaluation/ply_positions.h"

#include <algorithm>
#include <filesystem>
#include <stdexcept>
#include <vector>

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
  // COLMAP's reader, which knows colours, rounds geo-referenced positions.
  const std::vector<Eigen::Vector3d> positions = ReadPlyPositions(ply_path);
  const std::vector<colmap::PlyPoint> points = colmap::ReadPly(ply_path);
  for (size_t i = 0; i < std::min(positions.size(), points.size()); ++i) {
    const colmap::PlyPoint& point = points[i];
    model->AddPoint3D(positions[i],
                      colmap::Track(),
                      Eigen::Matrix<uint8_t, 3, 1>(point.r, point.g, point.b));
  }
  return model;
}

}  // namespace structnerf
