#include "nerf/scene_guards.h"

#include "nerf/util/median.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <stdexcept>
#include <utility>

namespace structnerf {
namespace {

// Grey levels that the pixels of a view of a single colour may span: what
// compression leaves of it.
constexpr int kMaxPlainRange = 2;

// Largest distance between where a point is and where it was seen.
constexpr double kMaxReprojectionError = 8;             // pixels
constexpr double kMaxRelativeReprojectionError = 0.02;  // of the longer side

// A camera is far from the others beyond this many times the distance from
// their middle that half of cameras and points have.
constexpr double kFarCamera = 10;

// Points that contradict their views are worth a warning from this share on.
constexpr double kManyContradictions = 0.1;

bool IsContradictory(const Scene& scene, const SparsePoint& point) {
  double sum = 0;  // of distances, 1 = the largest allowed
  for (const Observation& observation : point.track) {
    const View& view = scene.views[observation.view_idx];
    const PinholeCamera& camera = view.camera;
    const Eigen::Vector3d in_view = view.CamFromWorld(point.xyz);
    const double longer_side = std::max(camera.width, camera.height);
    double distance = longer_side;
    if (in_view.z() > 0) {
      const Eigen::Vector2d projected(
          camera.fx * in_view.x() / in_view.z() + camera.cx,
          camera.fy * in_view.y() / in_view.z() + camera.cy);
      // A single one must not outweigh a whole track.
      distance = std::min(longer_side, (projected - observation.xy).norm());
    }
    sum += distance / std::max(kMaxReprojectionError,
                               kMaxRelativeReprojectionError * longer_side);
  }
  return sum > static_cast<double>(point.track.size());
}

bool HasSingleColor(const View& view) {
  uint8_t low[3] = {255, 255, 255};
  uint8_t high[3] = {0, 0, 0};
  bool has_pixel = false;
  const size_t num_pixels = view.image.data.size() / 3;
  for (size_t i = 0; i < num_pixels; ++i) {
    if (!view.mask.empty() && view.mask[i] == 0) {
      continue;
    }
    has_pixel = true;
    for (int c = 0; c < 3; ++c) {
      const uint8_t value = view.image.data[3 * i + c];
      low[c] = std::min(low[c], value);
      high[c] = std::max(high[c], value);
      if (high[c] - low[c] > kMaxPlainRange) {
        return false;
      }
    }
  }
  return has_pixel;
}

// Distance of each camera from the median of all, 1 = that of half of the
// cameras or of half of the points, whichever is larger.
std::vector<double> RelativeDistances(const Scene& scene) {
  std::vector<Eigen::Vector3d> centers;
  std::vector<double> coordinates[3];
  for (const View& view : scene.views) {
    centers.push_back(view.ProjectionCenter());
    for (int axis = 0; axis < 3; ++axis) {
      coordinates[axis].push_back(centers.back()[axis]);
    }
  }
  const Eigen::Vector3d middle(Median(&coordinates[0]),
                               Median(&coordinates[1]),
                               Median(&coordinates[2]));
  std::vector<double> distances;
  for (const Eigen::Vector3d& center : centers) {
    distances.push_back((center - middle).norm());
  }
  std::vector<double> of_points;
  for (const SparsePoint& point : scene.points) {
    of_points.push_back((point.xyz - middle).norm());
  }
  std::vector<double> of_cameras = distances;
  const double unit = std::max(Median(&of_cameras), Median(&of_points));
  for (double& distance : distances) {
    distance = unit > 0 ? distance / unit : 0;
  }
  return distances;
}

}  // namespace

int RemoveContradictoryPoints(Scene* scene) {
  std::vector<SparsePoint> others;
  std::copy_if(scene->points.begin(),
               scene->points.end(),
               std::back_inserter(others),
               [&](const SparsePoint& point) {
                 return !IsContradictory(*scene, point);
               });
  const size_t num_contradictory = scene->points.size() - others.size();
  if (2 * num_contradictory <= scene->points.size()) {
    scene->points = std::move(others);
  }
  return static_cast<int>(num_contradictory);
}

SceneFindings InspectScene(const Scene& scene,
                           const std::vector<std::vector<int>>& sources,
                           const int num_contradictory) {
  if (std::all_of(sources.begin(), sources.end(), [](const auto& of_view) {
        return of_view.empty();
      })) {
    throw std::invalid_argument(
        "no image has another one to compare it with: all cameras stand in one "
        "place, or they look apart and share no sparse points. Depth needs "
        "images that see the same things from different places");
  }
  std::vector<size_t> num_points(scene.views.size(), 0);
  for (const SparsePoint& point : scene.points) {
    for (const Observation& observation : point.track) {
      ++num_points[observation.view_idx];
    }
  }
  SceneFindings findings;
  findings.counts["contradictory_point"] = num_contradictory;
  // Of all points, those that were removed included.
  const size_t num_points_before = scene.points.size() + num_contradictory;
  if (num_contradictory > kManyContradictions * num_points_before) {
    findings.warnings.push_back(
        std::to_string(num_contradictory) +
        " sparse points do not project to where the images saw them; poses and "
        "points may not belong together");
  }
  int& num_without_points = findings.counts["view_without_points"];
  int& num_without_baseline = findings.counts["view_without_baseline"];
  int& num_plain = findings.counts["view_of_single_color"];
  int& num_far = findings.counts["view_far_from_others"];
  const std::vector<double> distances = RelativeDistances(scene);
  for (size_t v = 0; v < scene.views.size(); ++v) {
    const std::string prefix = "image " + scene.views[v].name + " ";
    if (num_points[v] == 0) {
      ++num_without_points;
      findings.warnings.push_back(
          prefix +
          "sees no sparse point; its depth rests on other views "
          "alone");
    }
    if (sources[v].empty()) {
      ++num_without_baseline;
      findings.warnings.push_back(prefix +
                                  "has no source view with a baseline; it is "
                                  "compared with nothing");
    }
    if (distances[v] > kFarCamera) {
      ++num_far;
      findings.warnings.push_back(
          prefix + "stands " + std::to_string(std::lround(distances[v])) +
          " times as far from the middle of the cameras as half of cameras and "
          "points; the field has to span that. If it is registered wrongly, "
          "remove it from the model");
    }
    if (HasSingleColor(scene.views[v])) {
      ++num_plain;
      findings.warnings.push_back(prefix +
                                  "shows a single colour; its depth rests on "
                                  "sparse points and other views alone");
    }
  }
  return findings;
}

}  // namespace structnerf
