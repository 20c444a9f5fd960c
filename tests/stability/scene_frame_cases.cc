// The same room in other units, far from the origin, and turned: the same
// depths must come out.

#include "nerf/util/median.h"
#include "tests/stability/room_run.h"
#include "tests/stability/stability_case.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <Eigen/Geometry>

namespace structnerf {
namespace {

// new_world = scale * rotation * world + translation
Scene Transformed(const double scale,
                  const Eigen::Matrix3d& rotation,
                  const Eigen::Vector3d& translation) {
  Scene scene = StabilityScene();
  for (View& view : scene.views) {
    const Eigen::Vector3d center =
        scale * (rotation * view.ProjectionCenter()) + translation;
    view.cam_from_world_rotation *= rotation.transpose();
    view.cam_from_world_translation = -(view.cam_from_world_rotation * center);
  }
  for (SparsePoint& point : scene.points) {
    point.xyz = scale * (rotation * point.xyz) + translation;
  }
  return scene;
}

// Points of a cloud against those of another one of the base room, relative to
// their depth, in the median. Both are back-projected in double and brought
// into the base's frame.
double CloudDifference(const std::vector<DenseMaps>& base_maps,
                       const Scene& scene,
                       const std::vector<DenseMaps>& maps,
                       const double scale,
                       const Eigen::Matrix3d& rotation,
                       const Eigen::Vector3d& translation) {
  std::vector<double> differences;
  for (size_t v = 0; v < maps.size(); ++v) {
    const View& base_view = StabilityScene().views[v];
    const View& view = scene.views[v];
    const PinholeCamera& camera = view.camera;
    for (int row = 0; row < camera.height; ++row) {
      for (int col = 0; col < camera.width; ++col) {
        const size_t pixel = static_cast<size_t>(row) * camera.width + col;
        const double base_depth = base_maps[v].depth[pixel];
        const Eigen::Vector3d ray(
            (col - camera.cx) / camera.fx, (row - camera.cy) / camera.fy, 1);
        const Eigen::Vector3d base_point =
            base_view.WorldFromCam(base_depth * ray);
        const Eigen::Vector3d point = view.cam_from_world_rotation.transpose() *
                                          (maps[v].depth[pixel] * ray) +
                                      view.ProjectionCenter();
        const Eigen::Vector3d in_base =
            rotation.transpose() * (point - translation) / scale;
        if (base_depth > 0 && maps[v].depth[pixel] > 0) {
          differences.push_back((in_base - base_point).norm() / base_depth);
        }
      }
    }
  }
  RequireStable(!differences.empty(), "no depths at all");
  return Median(&differences);
}

// Without refinement, which chooses between nearly equal matches.
ReconstructionOptions FewSteps() {
  ReconstructionOptions options = StabilityOptions();
  options.training.num_steps = 10;
  options.stereo.num_iterations = 0;
  return options;
}

const RoomRun& ShortBaseRun() {
  static const RoomRun run = RunScene(StabilityScene(), FewSteps());
  return run;
}

// Training amplifies the last bit of a pose: what rounds differently is another
// run in the end, like one from another seed. So the clouds are compared after
// a few steps, within `max_difference`, and at the end with what another seed
// does.
std::string MeasureTransformed(const double scale,
                               const Eigen::Matrix3d& rotation,
                               const Eigen::Vector3d& translation,
                               const double max_difference) {
  const Scene scene = Transformed(scale, rotation, translation);
  const auto difference = [&](const RoomRun& base, const RoomRun& run) {
    return CloudDifference(
        base.maps, scene, run.maps, scale, rotation, translation);
  };
  const double few_steps =
      difference(ShortBaseRun(), RunScene(scene, FewSteps()));
  const RoomRun run = RunScene(scene, StabilityOptions());
  const double all_steps = difference(BaseRun(), run);
  static const double other_seed = CloudDifference(BaseRun().maps,
                                                   StabilityScene(),
                                                   OtherSeedRun().maps,
                                                   1,
                                                   Eigen::Matrix3d::Identity(),
                                                   Eigen::Vector3d::Zero());
  const double error = MedianError(run.maps, scale);
  const double base_error = MedianError(BaseRun().maps);
  const std::string text =
      "cloud differs by " + ShortNumber(few_steps) +
      " of depth after 10 steps, " + ShortNumber(all_steps) +
      " in the end (another seed: " + ShortNumber(other_seed) + "); error " +
      ShortNumber(error) + " %, base " + ShortNumber(base_error) + " %" +
      GuardText(run.summary);
  // A room that is turned has another box, so another grid, too.
  const double max_in_the_end = (rotation.isIdentity() ? 1.5 : 2) * other_seed;
  RequireStable(few_steps <= max_difference && all_steps < max_in_the_end &&
                    error < 1.5 * base_error,
                text);
  return text;
}

// NeRF's networks, small, do not see units and places either.
std::string MeasureTransformedNetworks(const double scale,
                                       const Eigen::Vector3d& translation,
                                       const double max_difference) {
  const Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  const Scene scene = Transformed(scale, rotation, translation);
  ReconstructionOptions options = FewSteps();
  options.field.type = "mlp";
  options.field.mlp_num_layers = 4;
  options.field.mlp_width = 32;
  options.sampling.num_fine_samples = 16;
  options.training.rays_per_step = 128;
  options.training.network_learning_rate = 5e-3;
  const double few_steps =
      CloudDifference(RunScene(StabilityScene(), options).maps,
                      scene,
                      RunScene(scene, options).maps,
                      scale,
                      rotation,
                      translation);
  options.training.num_steps = 60;
  const RoomRun run = RunScene(scene, options);
  const double error = MedianError(run.maps, scale);
  const double base_error =
      MedianError(RunScene(StabilityScene(), options).maps);
  const std::string text =
      "cloud differs by " + ShortNumber(few_steps) +
      " of depth after 10 steps; error after 60 " + ShortNumber(error) +
      " %, base " + ShortNumber(base_error) + " %" + GuardText(run.summary);
  RequireStable(few_steps <= max_difference && error < 2 * base_error, text);
  return text;
}

}  // namespace

std::vector<StabilityCase> SceneFrameCases() {
  // The same numbers up to the rounding of poses in double enter training.
  constexpr double kSameRun = 5e-4;
  // Another box around the room is another grid, so another run altogether.
  constexpr double kOtherRun = 0.1;
  const Eigen::Matrix3d identity = Eigen::Matrix3d::Identity();
  const Eigen::Vector3d zero = Eigen::Vector3d::Zero();
  std::vector<StabilityCase> cases;
  for (const double exponent : {-6, -3, 3, 6}) {
    const double scale = std::pow(10.0, exponent);
    cases.push_back(
        {"scale " + ShortNumber(scale),
         [=] { return MeasureTransformed(scale, identity, zero, kSameRun); }});
    cases.back().is_slow = std::abs(exponent) < 6;
  }
  for (const double offset : {1e3, 1e5, 1e6, 1e7}) {
    const Eigen::Vector3d translation(offset, -0.7 * offset, 0.01 * offset);
    cases.push_back({"offset " + ShortNumber(offset), [=] {
                       return MeasureTransformed(
                           1, identity, translation, kSameRun);
                     }});
    cases.back().is_slow = offset < 1e6;
  }
  // Poses at 1e7 room sizes are rounded to 1e-9 of a room.
  cases.push_back(
      {"scale 1e-06, offset 10", [=] {
         return MeasureTransformed(1e-6, identity, {10, -7, 0.1}, kSameRun);
       }});
  cases.push_back(
      {"field mlp, scale 1e-06, offset 10", [=] {
         return MeasureTransformedNetworks(1e-6, {10, -7, 0.1}, kSameRun);
       }});
  int number = 0;
  for (const Eigen::Vector3d& axis : {Eigen::Vector3d(0, 0, 1),
                                      Eigen::Vector3d(1, 2, 3),
                                      Eigen::Vector3d(-3, 1, 0.5)}) {
    const Eigen::Matrix3d rotation =
        Eigen::AngleAxisd(0.7 + number, axis.normalized()).toRotationMatrix();
    cases.push_back(
        {"rotation " + std::to_string(++number), [=] {
           return MeasureTransformed(1, rotation, {1e6, 2e6, 3e6}, kOtherRun);
         }});
    cases.back().is_slow = number > 1;
  }
  // Quarter turns give the same box.
  const Eigen::Matrix3d quarter =
      Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitX()).toRotationMatrix();
  cases.push_back(
      {"rotation by a quarter, scale 1e+03, offset 1e+06", [=] {
         return MeasureTransformed(1e3, quarter, {1e6, 1e6, -1e6}, kOtherRun);
       }});
  return cases;
}

}  // namespace structnerf
