// Sparse models that are wrong or tell little.

#include "nerf/scene_frame.h"
#include "nerf/util/random.h"
#include "tests/nerf/plane_scene.h"
#include "tests/stability/room_run.h"
#include "tests/stability/stability_case.h"

#include <algorithm>
#include <functional>
#include <string>
#include <vector>

namespace structnerf {
namespace {

// Applies a change to a share of the points.
Scene WithPoints(
    const double share,
    const std::function<void(const Scene&, Random*, SparsePoint*)>& change) {
  Scene scene = StabilityScene();
  Random random(7);
  for (SparsePoint& point : scene.points) {
    if (random.NextFloat() < share) {
      change(scene, &random, &point);
    }
  }
  return scene;
}

// Somewhere in a cube of `size` around the origin.
Eigen::Vector3d RandomPlace(const double size, Random* random) {
  Eigen::Vector3d place;
  for (int axis = 0; axis < 3; ++axis) {
    place[axis] = size * (random->NextFloat() - 0.5);
  }
  return place;
}

std::string Measure(
    const double share,
    const double max_error,
    const std::function<void(const Scene&, Random*, SparsePoint*)>& change) {
  return MeasureScene(WithPoints(share, change), StabilityOptions(), max_error);
}

std::string MeasureHalfWithoutPoints() {
  Scene scene = StabilityScene();
  for (SparsePoint& point : scene.points) {
    point.track.erase(std::remove_if(point.track.begin(),
                                     point.track.end(),
                                     [](const Observation& observation) {
                                       return observation.view_idx % 2 == 0;
                                     }),
                      point.track.end());
  }
  return MeasureScene(scene, StabilityOptions(), 15);
}

}  // namespace

std::vector<StabilityCase> SparseModelCases() {
  const double base = 10;  // percent; the room as it is has about 4
  // Nothing but the images speaks against them.
  constexpr double kWrongMatches = 30;
  std::vector<StabilityCase> cases;
  cases.push_back({"no points on half the views", MeasureHalfWithoutPoints});
  cases.push_back(
      {"30 % outliers within 20 m", [=] {
         return Measure(0.3, 2 * base, [](const Scene&, auto* random, auto* p) {
           p->xyz = RandomPlace(20, random);
         });
       }});
  cases.push_back(
      {"30 % outliers along their rays", [=] {
         return Measure(
             0.3, 2 * base, [](const Scene& scene, auto* random, auto* p) {
               const Eigen::Vector3d center =
                   scene.views[p->track[0].view_idx].ProjectionCenter();
               p->xyz = center + 4 * random->NextFloat() * (p->xyz - center);
             });
       }});
  cases.push_back(
      {"30 % outliers at 1e12 m", [=] {
         return Measure(0.3, 2 * base, [](const Scene&, auto* random, auto* p) {
           p->xyz = RandomPlace(1e12, random);
         });
       }});
  cases.push_back(
      {"30 % wrong matches, each of two views", [=] {
         return Measure(
             0.3, kWrongMatches, [](const Scene& scene, auto* random, auto* p) {
               const Eigen::Vector3d center =
                   scene.views[p->track[0].view_idx].ProjectionCenter();
               p->xyz =
                   center + (0.5 + random->NextFloat()) * (p->xyz - center);
               p->track.resize(2);
               p->track[1].xy =
                   Project(scene.views[p->track[1].view_idx], p->xyz)
                       .template head<2>();
             });
       }});
  cases.push_back(
      {"30 % of the points behind their cameras", [=] {
         return Measure(0.3, base, [](const Scene& scene, auto*, auto* p) {
           const Eigen::Vector3d center =
               scene.views[p->track[0].view_idx].ProjectionCenter();
           p->xyz = center - (p->xyz - center);
         });
       }});
  cases.push_back(
      {"all points behind their cameras",
       [] {
         RunScene(
             WithPoints(
                 1.0,
                 [](const Scene& scene, auto*, auto* p) {
                   double depth = 0;
                   for (const auto& o : p->track) {
                     depth = std::max(
                         depth, DepthInView(scene.views[o.view_idx], p->xyz));
                   }
                   const View& view = scene.views[p->track[0].view_idx];
                   p->track.resize(1);
                   p->xyz -= 2 * depth *
                             view.cam_from_world_rotation.row(2).transpose();
                 }),
             StabilityOptions());
         return std::string();
       },
       "no points in front of its images"});
  cases.push_back(
      {"5 % of the points inside their camera", [=] {
         return Measure(
             0.05, base, [](const Scene& scene, auto* random, auto* p) {
               const View& view = scene.views[p->track[0].view_idx];
               p->xyz = view.ProjectionCenter() +
                        1e-13 * random->NextFloat() *
                            view.cam_from_world_rotation.row(2).transpose();
             });
       }});
  for (const double error : {0.0, -1.0, 1e9, 1e-300}) {
    cases.push_back({"reprojection errors all " + ShortNumber(error), [=] {
                       return Measure(
                           1.0, base, [=](const Scene&, auto*, auto* p) {
                             p->error = error;
                           });
                     }});
    cases.back().is_slow = error > 0;
  }
  cases.push_back({"one point", [] {
                     Scene scene = StabilityScene();
                     scene.points.resize(1);
                     const RoomRun run = RunScene(scene, StabilityOptions());
                     return "error " + ShortNumber(MedianError(run.maps)) +
                            " %" + GuardText(run.summary);
                   }});
  cases.push_back({"no points",
                   [] {
                     Scene scene = StabilityScene();
                     scene.points.clear();
                     RunScene(scene, StabilityOptions());
                     return std::string();
                   },
                   "no points in front of its images"});
  return cases;
}

}  // namespace structnerf
