#include "colmap_plugin/rendering/novel_path.h"

#include "nerf/scene_frame.h"
#include "nerf/util/median.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <unordered_set>

#include <Eigen/Geometry>

namespace structnerf {
namespace {

std::string FrameName(const int frame) {
  char name[32];
  snprintf(name, sizeof(name), "frame_%04d", frame);
  return name;
}

View MakeView(const std::string& name,
              const PinholeCamera& camera,
              const Eigen::Matrix3d& cam_from_world_rotation,
              const Eigen::Vector3d& center) {
  View view;
  view.name = name;
  view.camera = camera;
  view.cam_from_world_rotation = cam_from_world_rotation;
  view.cam_from_world_translation = -cam_from_world_rotation * center;
  return view;
}

}  // namespace

std::vector<View> InterpolateViews(const std::vector<View>& views,
                                   const PinholeCamera& camera,
                                   const int num_frames) {
  if (views.size() < 2 || num_frames < 2) {
    throw std::invalid_argument(
        "a path needs at least two views and two frames");
  }
  std::vector<View> path;
  for (int frame = 0; frame < num_frames; ++frame) {
    const double place = static_cast<double>(frame) / (num_frames - 1) *
                         static_cast<double>(views.size() - 1);
    const size_t first = std::min(static_cast<size_t>(place), views.size() - 2);
    const double share = place - static_cast<double>(first);
    const View& from = views[first];
    const View& to = views[first + 1];
    const Eigen::Quaterniond rotation =
        Eigen::Quaterniond(from.cam_from_world_rotation)
            .slerp(share, Eigen::Quaterniond(to.cam_from_world_rotation));
    path.push_back(MakeView(
        FrameName(frame),
        camera,
        rotation.toRotationMatrix(),
        (1 - share) * from.ProjectionCenter() + share * to.ProjectionCenter()));
  }
  return path;
}

std::vector<View> OrbitView(const View& view,
                            const double depth,
                            const double radius,
                            const int num_frames) {
  const Eigen::Matrix3d& axes = view.cam_from_world_rotation;
  const Eigen::Vector3d target =
      view.ProjectionCenter() + depth * axes.row(2).transpose();
  std::vector<View> path;
  for (int frame = 0; frame < num_frames; ++frame) {
    const double angle = 2 * M_PI * frame / num_frames;
    const Eigen::Vector3d center =
        view.ProjectionCenter() +
        radius * (std::cos(angle) * axes.row(0).transpose() +
                  std::sin(angle) * axes.row(1).transpose());
    const Eigen::Vector3d forward = (target - center).normalized();
    const Eigen::Vector3d right =
        axes.row(1).transpose().cross(forward).normalized();
    Eigen::Matrix3d rotation;
    rotation << right.transpose(), forward.cross(right).transpose(),
        forward.transpose();
    path.push_back(MakeView(FrameName(frame), view.camera, rotation, center));
  }
  return path;
}

std::vector<View> ReadPoses(const std::string& path,
                            const PinholeCamera& camera) {
  std::ifstream file(path);
  if (!file) {
    throw std::runtime_error("The file " + path +
                             " of --poses_path cannot be read.");
  }
  std::vector<View> views;
  std::unordered_set<std::string> names;
  int line_number = 0;
  for (std::string line; std::getline(file, line);) {
    ++line_number;
    std::istringstream stream(line);
    std::string name;
    if (!(stream >> name) || name[0] == '#') {
      continue;
    }
    double values[7];
    for (double& value : values) {
      stream >> value;
    }
    const Eigen::Quaterniond rotation(
        values[0], values[1], values[2], values[3]);
    std::string rest;
    if (!stream || stream >> rest || std::abs(rotation.norm() - 1) > 0.01) {
      throw std::runtime_error(
          "Line " + std::to_string(line_number) + " of " + path +
          " must be a name, a unit quaternion and a translation: NAME QW QX "
          "QY QZ TX TY TZ.");
    }
    if (!names.insert(name).second) {
      throw std::runtime_error("Line " + std::to_string(line_number) + " of " +
                               path + " repeats a name of an earlier line.");
    }
    View view;
    view.name = name;
    view.camera = camera;
    view.cam_from_world_rotation = rotation.normalized().toRotationMatrix();
    view.cam_from_world_translation = {values[4], values[5], values[6]};
    views.push_back(std::move(view));
  }
  if (views.empty()) {
    throw std::runtime_error("The file " + path +
                             " of --poses_path has no pose.");
  }
  return views;
}

double MedianPointDepth(const Scene& scene, const size_t view_idx) {
  std::vector<double> observed;
  std::vector<double> all;
  for (const SparsePoint& point : scene.points) {
    const double depth = DepthInView(scene.views[view_idx], point.xyz);
    if (depth <= 0) {
      continue;
    }
    all.push_back(depth);
    if (std::any_of(point.track.begin(),
                    point.track.end(),
                    [&](const Observation& observation) {
                      return observation.view_idx == static_cast<int>(view_idx);
                    })) {
      observed.push_back(depth);
    }
  }
  std::vector<double>& depths = observed.empty() ? all : observed;
  if (depths.empty()) {
    throw std::invalid_argument(
        "The model has no sparse point before image " +
        scene.views[view_idx].name +
        ", so how deep it is cannot be told; the model of --workspace_path "
        "must be the one that the field was trained on.");
  }
  return Median(&depths);
}

}  // namespace structnerf
