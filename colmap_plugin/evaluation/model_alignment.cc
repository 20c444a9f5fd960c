#include "colmap_plugin/evaluation/model_alignment.h"

#include <cmath>
#include <stdexcept>
#include <string>
#include <unordered_map>
#include <utility>

#include <Eigen/LU>
#include <Eigen/SVD>

namespace structnerf {
namespace {

// The rotation nearest to a matrix.
Eigen::Matrix3d NearestRotation(const Eigen::Matrix3d& matrix) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(
      matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d rotation = svd.matrixU() * svd.matrixV().transpose();
  if (rotation.determinant() < 0) {
    Eigen::Matrix3d u = svd.matrixU();
    u.col(2) *= -1;
    rotation = u * svd.matrixV().transpose();
  }
  return rotation;
}

}  // namespace

View ModelAlignment::Apply(const View& view) const {
  View aligned = view;
  aligned.cam_from_world_rotation =
      view.cam_from_world_rotation * rotation.transpose();
  aligned.cam_from_world_translation =
      scale * view.cam_from_world_translation -
      aligned.cam_from_world_rotation * translation;
  return aligned;
}

ModelAlignment AlignModels(const std::vector<View>& source,
                           const std::vector<View>& target) {
  std::unordered_map<std::string, const View*> target_views;
  for (const View& view : target) {
    target_views.emplace(view.name, &view);
  }
  std::vector<std::pair<const View*, const View*>> pairs;
  for (const View& view : source) {
    const auto found = target_views.find(view.name);
    if (found != target_views.end()) {
      pairs.emplace_back(&view, found->second);
    }
  }

  ModelAlignment alignment;
  alignment.num_common_views = pairs.size();
  Eigen::Matrix3d rotation_sum = Eigen::Matrix3d::Zero();
  Eigen::Vector3d source_mean = Eigen::Vector3d::Zero();
  Eigen::Vector3d target_mean = Eigen::Vector3d::Zero();
  for (const auto& [from, to] : pairs) {
    rotation_sum +=
        to->cam_from_world_rotation.transpose() * from->cam_from_world_rotation;
    source_mean += from->ProjectionCenter() / pairs.size();
    target_mean += to->ProjectionCenter() / pairs.size();
  }
  alignment.rotation = NearestRotation(rotation_sum);
  double source_spread = 0;
  double target_spread = 0;
  double product = 0;
  for (const auto& [from, to] : pairs) {
    const Eigen::Vector3d x =
        alignment.rotation * (from->ProjectionCenter() - source_mean);
    const Eigen::Vector3d y = to->ProjectionCenter() - target_mean;
    source_spread += x.squaredNorm();
    target_spread += y.squaredNorm();
    product += x.dot(y);
  }
  if (!(source_spread > 0) || !(target_spread > 0) || !(product > 0)) {
    throw std::runtime_error(
        "The two models have " + std::to_string(pairs.size()) +
        " images in common, from which they cannot be aligned; at least two at "
        "different places are needed.");
  }
  alignment.scale = product / source_spread;
  alignment.translation =
      target_mean - alignment.scale * alignment.rotation * source_mean;
  double squared_error = 0;
  for (const auto& [from, to] : pairs) {
    squared_error +=
        (to->ProjectionCenter() - alignment.Apply(*from).ProjectionCenter())
            .squaredNorm();
  }
  alignment.relative_error = std::sqrt(squared_error / target_spread);
  return alignment;
}

}  // namespace structnerf
