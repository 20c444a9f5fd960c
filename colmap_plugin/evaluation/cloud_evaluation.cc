#include "colmap_plugin/evaluation/cloud_evaluation.h"

#include "colmap_plugin/colmap_compat.h"
#include "colmap_plugin/evaluation/ply_positions.h"
#include "colmap_plugin/evaluation/voxel_cloud.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace structnerf {
namespace {

// Rays this far from the optical axis (tangent) are outside of any image, and
// of what distortion models are good for.
constexpr double kMaxTangent = 3;
constexpr double kMinDepth = 1e-6;  // metres

// Clouds are compared in metres relative to a point of the scene:
// geo-referenced ones are far from the origin.
struct MetricFrame {
  double metres_per_unit = 1;
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  // units
};

std::vector<Eigen::Vector3d> ReadCloud(const std::string& path,
                                       const MetricFrame& frame,
                                       const double voxel_size,
                                       size_t* num_fused_points) {
  VoxelCloud cloud(voxel_size);
  const std::vector<Eigen::Vector3d> points = ReadPlyPositions(path);
  *num_fused_points = points.size();
  for (const Eigen::Vector3d& point : points) {
    cloud.Add(frame.metres_per_unit * (point - frame.origin));
  }
  return cloud.Points();
}

struct MetricPose {
  MetricPose(const colmap::Image& image, const MetricFrame& frame) {
    const Eigen::Matrix3x4d matrix = image.CamFromWorld().ToMatrix();
    rotation = matrix.leftCols<3>();
    translation =
        frame.metres_per_unit * (matrix.col(3) + rotation * frame.origin);
  }
  Eigen::Matrix3d rotation;
  Eigen::Vector3d translation;
};

std::vector<Eigen::Vector3d> MakeTrueCloud(const MetricFrame& frame,
                                           const double voxel_size,
                                           TruthViews* truth,
                                           StageProgress* progress) {
  VoxelCloud cloud(voxel_size);
  size_t num_done = 0;
  for (const std::string& name : truth->Names()) {
    progress->Report(num_done++, truth->Names().size());
    const cv::Mat1f depth = truth->Depth(name);
    const cv::Mat2d& rays = truth->Rays(name, depth.size());
    const MetricPose pose(truth->Image(name), frame);
    for (int row = 0; row < depth.rows; ++row) {
      for (int col = 0; col < depth.cols; ++col) {
        const double z = depth(row, col);
        if (z > 0) {
          const cv::Vec2d& ray = rays(row, col);
          const Eigen::Vector3d x_in_cam(z * ray[0], z * ray[1], z);
          cloud.Add(pose.rotation.transpose() * (x_in_cam - pose.translation));
        }
      }
    }
  }
  return cloud.Points();
}

bool IsObserved(const Eigen::Vector3d& point,
                const MetricPose& pose,
                const colmap::Camera& camera,
                const cv::Mat1f& depth) {
  const Eigen::Vector3d x_in_cam = pose.rotation * point + pose.translation;
  if (x_in_cam.z() < kMinDepth) {
    return false;
  }
  const Eigen::Vector2d ray = x_in_cam.head<2>() / x_in_cam.z();
  Eigen::Vector2d image_point;
  if (ray.cwiseAbs().maxCoeff() >= kMaxTangent ||
      !ImagePointFromRay(camera, ray, &image_point)) {
    return false;
  }
  const double x = std::floor(image_point.x() * depth.cols / camera.width);
  const double y = std::floor(image_point.y() * depth.rows / camera.height);
  return x >= 0 && y >= 0 && x < depth.cols && y < depth.rows &&
         depth(static_cast<int>(y), static_cast<int>(x)) > 0;
}

std::vector<Eigen::Vector3d> KeepObserved(
    const std::vector<Eigen::Vector3d>& points,
    const MetricFrame& frame,
    const TruthViews& truth,
    StageProgress* progress) {
  std::vector<Eigen::Vector3d> observed;
  std::vector<Eigen::Vector3d> remaining = points;
  size_t num_done = 0;
  for (const std::string& name : truth.Names()) {
    progress->Report(num_done++, truth.Names().size());
    const cv::Mat1f depth = truth.Depth(name);
    const MetricPose pose(truth.Image(name), frame);
    const auto first_observed = std::partition(
        remaining.begin(), remaining.end(), [&](const Eigen::Vector3d& point) {
          return !IsObserved(point, pose, truth.Camera(name), depth);
        });
    observed.insert(observed.end(), first_observed, remaining.end());
    remaining.erase(first_observed, remaining.end());
  }
  return observed;
}

}  // namespace

void CloudEvaluationOptions::Check() const {
  if (!(voxel_size > 0) || !std::isfinite(voxel_size)) {
    throw std::runtime_error("The option --voxel_size must be positive.");
  }
}

CloudEvaluation EvaluateCloud(const std::string& ply_path,
                              const double metres_per_unit,
                              const CloudEvaluationOptions& options,
                              TruthViews* truth,
                              StageProgress* progress) {
  options.Check();
  CloudEvaluation evaluation;
  const MetricFrame frame{
      metres_per_unit, truth->Image(truth->Names().front()).ProjectionCenter()};
  std::vector<Eigen::Vector3d> predicted = ReadCloud(
      ply_path, frame, options.voxel_size, &evaluation.num_fused_points);
  // Where the truth is masked, nothing is compared.
  if (options.mask_unobserved || truth->HasMasks()) {
    const size_t num_points = predicted.size();
    predicted = KeepObserved(predicted, frame, *truth, progress);
    evaluation.num_unobserved_points = num_points - predicted.size();
  }
  evaluation.metrics = CompareClouds(
      predicted, MakeTrueCloud(frame, options.voxel_size, truth, progress));
  return evaluation;
}

}  // namespace structnerf
