// Lenses from fisheye-wide to extreme tele, few and many views, and cameras
// that stand badly.

#include "nerf/util/median.h"
#include "tests/nerf/plane_scene.h"
#include "tests/stability/room_run.h"
#include "tests/stability/stability_case.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace structnerf {
namespace {

constexpr int kWidth = 32;
constexpr int kHeight = 24;
constexpr double kWallDistance = 4;

// Sparse points beyond are not made: rays along a plane meet it nowhere.
constexpr double kFarthest = 1.1e4;

// Adds sparse points on the plane at every `stride`-th pixel of every view,
// each seen by all views that it falls into.
void AddPoints(const TexturedPlane& plane, const int stride, Scene* scene) {
  for (const View& view : scene->views) {
    for (int row = 1; row < view.camera.height; row += stride) {
      for (int col = 1; col < view.camera.width; col += stride) {
        const double depth = plane.Depth(view, col, row);
        if (!(depth > 0 && depth < kFarthest)) {
          continue;
        }
        const PinholeCamera& camera = view.camera;
        const Eigen::Vector3d in_view(depth * (col - camera.cx) / camera.fx,
                                      depth * (row - camera.cy) / camera.fy,
                                      depth);
        const Eigen::Vector3d xyz = view.WorldFromCam(in_view);
        std::vector<int> view_idxs;
        for (size_t v = 0; v < scene->views.size(); ++v) {
          const Eigen::Vector3d image_point = Project(scene->views[v], xyz);
          if (image_point.z() > 0 && image_point.x() > 0 &&
              image_point.x() < camera.width && image_point.y() > 0 &&
              image_point.y() < camera.height) {
            view_idxs.push_back(static_cast<int>(v));
          }
        }
        scene->points.push_back(MakePoint(*scene, xyz, view_idxs));
      }
    }
  }
}

// Views of a wall from the given places, all looking at its middle.
Scene MakeWallScene(const TexturedPlane& plane,
                    const double focal_length,
                    const std::vector<Eigen::Vector3d>& centers,
                    const Eigen::Vector3d& target) {
  Scene scene;
  for (size_t v = 0; v < centers.size(); ++v) {
    View view = MakeView("view" + std::to_string(v) + ".jpg",
                         MakeCamera(kWidth, kHeight, focal_length),
                         centers[v],
                         target - centers[v]);
    plane.Photograph(kWidth, kHeight, &view);
    scene.views.push_back(view);
  }
  AddPoints(plane, 6, &scene);
  return scene;
}

std::vector<Eigen::Vector3d> Grid(const double baseline) {
  std::vector<Eigen::Vector3d> centers;
  for (int i = 0; i < 6; ++i) {
    centers.emplace_back(baseline * (i % 3 - 1), 0.7 * baseline * (i / 3), 0);
  }
  return centers;
}

// Median relative error of depth in percent over the pixels that `is_counted`
// takes, a missing depth counting as 100.
double WallError(const TexturedPlane& plane,
                 const Scene& scene,
                 const std::vector<DenseMaps>& maps,
                 const std::function<bool(double depth)>& is_counted) {
  std::vector<double> errors;
  for (size_t v = 0; v < maps.size(); ++v) {
    for (int row = 0; row < maps[v].height; ++row) {
      for (int col = 0; col < maps[v].width; ++col) {
        const double truth = plane.Depth(scene.views[v], col, row);
        if (truth > 0 && is_counted(truth)) {
          const float depth =
              maps[v].depth[static_cast<size_t>(row) * maps[v].width + col];
          errors.push_back(100 * std::abs(depth / truth - 1));
        }
      }
    }
  }
  return Median(&errors);
}

std::string MeasureWall(const TexturedPlane& plane,
                        const Scene& scene,
                        const double max_error) {
  const RoomRun run = RunScene(scene, StabilityOptions());
  const double error =
      WallError(plane, scene, run.maps, [](double) { return true; });
  const std::string text =
      "error " + ShortNumber(error) + " %" + GuardText(run.summary);
  RequireStable(error <= max_error, text);
  return text;
}

std::string MeasureFocalLength(const double focal_length) {
  // As wide a lens sees much of the wall, as far a tele little of it.
  const double visible = kWallDistance * kWidth / focal_length;
  TexturedPlane plane;
  // Between the views of a tele lens lie many pixels: what repeats within them
  // fits at other depths, too.
  plane.wavelength = (focal_length > kWidth ? 0.5 : 0.15) * visible;
  const Scene scene = MakeWallScene(
      plane, focal_length, Grid(0.4), Eigen::Vector3d(0, 0, kWallDistance));
  // Near the limit of what a pinhole can be, a pixel is ten degrees wide.
  return MeasureWall(plane, scene, focal_length < 0.1 * kWidth ? 40 : 10);
}

// A plane whose inverse depth falls from 1 at the left side of the image to
// 1e-4 at its last column.
std::string MeasureDepthRange() {
  TexturedPlane plane;
  const double slope = (1e-4 - 1) * kWidth / (kWidth - 1);
  plane.normal = Eigen::Vector3d(slope, 0, 1 + 0.5 * slope);
  plane.point = plane.normal / plane.normal.squaredNorm();
  plane.wavelength = 0.5;
  Scene scene;
  for (int v = 0; v < 6; ++v) {
    View view = MakeView("view" + std::to_string(v) + ".jpg",
                         MakeCamera(kWidth, kHeight, kWidth),
                         {0.02 * (v % 3), 0.05 * (v / 3), 0});
    plane.Photograph(kWidth, kHeight, &view);
    scene.views.push_back(view);
  }
  AddPoints(plane, 3, &scene);
  double nearest = 1e9;
  double farthest = 0;
  for (const SparsePoint& point : scene.points) {
    nearest = std::min(nearest, point.xyz.z());
    farthest = std::max(farthest, point.xyz.z());
  }
  const RoomRun run = RunScene(scene, StabilityOptions());
  const auto error = [&](const double from, const double to) {
    return WallError(plane, scene, run.maps, [=](const double depth) {
      return depth >= from && depth < to;
    });
  };
  RequireStable(nearest < 1.1 && farthest > 9e3, "the depths are others");
  const double near_error = error(0, 4);
  const double far_error = error(4, 1e9);
  const std::string text =
      "points from " + ShortNumber(nearest) + " to " + ShortNumber(farthest) +
      "; error " + ShortNumber(near_error) + " % below 4, " +
      ShortNumber(far_error) + " % beyond" + GuardText(run.summary);
  // A single column of pixels is beyond 31.
  RequireStable(near_error <= 15 && far_error <= 40, text);
  return text;
}

Scene FirstViews(const size_t num_views) {
  Scene scene = StabilityScene();
  scene.views.resize(num_views);
  std::vector<SparsePoint> points;
  for (SparsePoint point : scene.points) {
    point.track.erase(std::remove_if(point.track.begin(),
                                     point.track.end(),
                                     [&](const Observation& observation) {
                                       return observation.view_idx >=
                                              static_cast<int>(num_views);
                                     }),
                      point.track.end());
    if (point.track.size() >= 2) {
      points.push_back(point);
    }
  }
  scene.points = points;
  return scene;
}

std::string MeasureManyViews(const int num_views) {
  TexturedPlane plane;
  std::vector<Eigen::Vector3d> centers;
  for (int i = 0; i < num_views; ++i) {
    centers.emplace_back(0.02 * (i % 25) - 0.25, 0.02 * (i / 25) - 0.2, 0);
  }
  const Scene scene = MakeWallScene(
      plane, kWidth, centers, Eigen::Vector3d(0, 0, kWallDistance));
  return MeasureWall(plane, scene, 10);
}

// The room from one place, each camera looking its own way.
std::string RunPureRotation() {
  Scene scene = StabilityScene();
  const Eigen::Vector3d center = scene.views[0].ProjectionCenter();
  for (View& view : scene.views) {
    view.cam_from_world_translation = -(view.cam_from_world_rotation * center);
  }
  RunScene(scene, StabilityOptions());
  return "";
}

std::string RunIdenticalCameras() {
  Scene scene = StabilityScene();
  for (View& view : scene.views) {
    view.cam_from_world_rotation = scene.views[0].cam_from_world_rotation;
    view.cam_from_world_translation = scene.views[0].cam_from_world_translation;
  }
  RunScene(scene, StabilityOptions());
  return "";
}

// Every photograph twice, as if an image had been copied.
std::string MeasureDoubledViews() {
  Scene scene = StabilityScene();
  const size_t num_views = scene.views.size();
  for (size_t v = 0; v < num_views; ++v) {
    scene.views.push_back(scene.views[v]);
  }
  for (SparsePoint& point : scene.points) {
    const std::vector<Observation> track = point.track;
    for (Observation observation : track) {
      observation.view_idx += static_cast<int>(num_views);
      point.track.push_back(observation);
    }
  }
  RoomRun run = RunScene(scene, StabilityOptions());
  run.maps.resize(num_views);
  const double error = MedianError(run.maps);
  const std::string text =
      "error " + ShortNumber(error) + " %" + GuardText(run.summary);
  RequireStable(error < 1.5 * MedianError(BaseRun().maps), text);
  return text;
}

std::string MeasureCollinear(const Eigen::Vector3d& step) {
  TexturedPlane plane;
  std::vector<Eigen::Vector3d> centers;
  for (int i = 0; i < 5; ++i) {
    centers.push_back(i * step);
  }
  const Scene scene = MakeWallScene(
      plane, kWidth, centers, Eigen::Vector3d(0, 0, kWallDistance));
  return MeasureWall(plane, scene, 10);
}

}  // namespace

std::vector<StabilityCase> CameraCases() {
  std::vector<StabilityCase> cases;
  for (const double focal_length : {1.5, 5.0, 300.0, 3e4, 3e6}) {
    const double angle =
        2 * std::atan(0.5 * kWidth / focal_length) * 180 / M_PI;
    cases.push_back({"field of view of " + ShortNumber(angle) + " degrees",
                     [=] { return MeasureFocalLength(focal_length); }});
    cases.back().is_slow = focal_length == 5 || focal_length == 300;
  }
  cases.push_back({"depths of 1 to 10,000", MeasureDepthRange});
  for (const size_t num_views : {2, 3}) {
    cases.push_back({std::to_string(num_views) + " views", [=] {
                       return MeasureScene(
                           FirstViews(num_views), StabilityOptions(), 15);
                     }});
  }
  cases.push_back({"500 views", [] { return MeasureManyViews(500); }});
  cases.back().is_slow = true;
  cases.push_back({"one view",
                   [] {
                     RunScene(FirstViews(1), StabilityOptions());
                     return std::string();
                   },
                   "fewer than two registered images"});
  cases.push_back({"zero baseline (pure rotation)",
                   RunPureRotation,
                   "all cameras stand in one place"});
  cases.push_back({"identical cameras",
                   RunIdenticalCameras,
                   "all cameras stand in one place"});
  cases.push_back({"every camera twice", MeasureDoubledViews});
  cases.push_back({"collinear cameras, along the view", [] {
                     return MeasureCollinear({0, 0, 0.35});
                   }});
  cases.push_back({"collinear cameras, across the view", [] {
                     return MeasureCollinear({0.2, 0, 0});
                   }});
  return cases;
}

}  // namespace structnerf
