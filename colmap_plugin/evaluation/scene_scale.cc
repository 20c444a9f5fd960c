#include "colmap_plugin/evaluation/scene_scale.h"

#include "nerf/util/median.h"

#include <cmath>

namespace structnerf {

void SceneScaleEstimator::AddImage(const colmap::Reconstruction& reconstruction,
                                   const colmap::Image& image,
                                   const cv::Mat1f& truth) {
  const colmap::Camera& camera = reconstruction.Camera(image.CameraId());
  for (const colmap::Point2D& point : image.Points2D()) {
    if (!point.HasPoint3D() ||
        !reconstruction.ExistsPoint3D(point.point3D_id)) {
      continue;
    }
    const Eigen::Vector3d x_in_cam =
        image.CamFromWorld() * reconstruction.Point3D(point.point3D_id).xyz;
    const double x = std::floor(point.xy.x() * truth.cols / camera.width);
    const double y = std::floor(point.xy.y() * truth.rows / camera.height);
    if (x_in_cam.z() > 0 && x >= 0 && y >= 0 && x < truth.cols &&
        y < truth.rows) {
      const double depth = truth(static_cast<int>(y), static_cast<int>(x));
      if (depth > 0) {
        ratios_.push_back(depth / x_in_cam.z());
      }
    }
  }
}

SceneScale SceneScaleEstimator::Estimate() const {
  SceneScale scale;
  if (ratios_.empty()) {
    return scale;
  }
  std::vector<double> values = ratios_;
  scale.num_observations = values.size();
  scale.metres_per_unit = Median(&values);
  for (double& value : values) {
    value = std::abs(value - scale.metres_per_unit);
  }
  scale.relative_spread = 1.4826 * Median(&values) / scale.metres_per_unit;
  return scale;
}

}  // namespace structnerf
