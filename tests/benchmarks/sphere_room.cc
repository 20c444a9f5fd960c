#include "tests/benchmarks/sphere_room.h"

#include "nerf/util/random.h"

#include <cmath>

#include <Eigen/Core>

namespace structnerf {
namespace {

constexpr int kNumCameras = 24;
constexpr float kRadius = 0.48f;
constexpr float kNear = 0.05f;
constexpr float kFar = 1.1f;

// Half the width of the image at depth one.
constexpr float kTanHalfFov = 0.6f;

const Eigen::Vector3f kCenter(0.5f, 0.5f, 0.5f);

}  // namespace

// Camera on a small circle, looking outwards. Columns: right, down, forward.
struct SphereRoomCamera {
  explicit SphereRoomCamera(const int index) {
    const float angle = 2 * static_cast<float>(M_PI) * index / kNumCameras;
    const Eigen::Vector3f forward(std::cos(angle), std::sin(angle), 0);
    center = kCenter + 0.12f * forward;
    axes.col(0) = Eigen::Vector3f(-forward.y(), forward.x(), 0);
    axes.col(1) = Eigen::Vector3f(0, 0, -1);
    axes.col(2) = forward;
  }

  Eigen::Vector3f center;
  Eigen::Matrix3f axes;
};

namespace {

// The ray through (u, v) in [-1, 1]^2.
void SetRay(const SphereRoomCamera& camera,
            const float u,
            const float v,
            const int ray,
            RayTile* rays) {
  const Eigen::Vector3f direction =
      camera.axes * Eigen::Vector3f(kTanHalfFov * u, kTanHalfFov * v, 1);
  for (int axis = 0; axis < 3; ++axis) {
    rays->origin[axis][ray] = camera.center[axis];
    rays->direction[axis][ray] = direction[axis];
  }
  rays->direction_norm[ray] = direction.norm();
  rays->near[ray] = kNear;
  rays->far[ray] = kFar;
}

Eigen::Vector3f Row(const PerRay<float>* values, const int ray) {
  return {values[0][ray], values[1][ray], values[2][ray]};
}

// Cheap, so that benchmarks measure the engine: a triangle wave of period 1.
float Wave(const float x) { return std::abs(2 * (x - std::floor(x)) - 1); }

}  // namespace

SphereRoomObjective::SphereRoomObjective() {
  for (int i = 0; i < kNumCameras; ++i) {
    cameras_.push_back(std::make_unique<SphereRoomCamera>(i));
  }
}

SphereRoomObjective::~SphereRoomObjective() = default;

float SphereRoomDepth(const RayTile& rays, const int ray) {
  const Eigen::Vector3f direction = Row(rays.direction, ray);
  const Eigen::Vector3f offset = Row(rays.origin, ray) - kCenter;
  const float a = direction.squaredNorm();
  const float b = direction.dot(offset);
  const float c = offset.squaredNorm() - kRadius * kRadius;
  return (std::sqrt(b * b - a * c) - b) / a;
}

void SphereRoomObjective::DrawRays(const int step,
                                   const int tile,
                                   RayTile* rays) {
  Random random(1, step, tile);
  rays_.num_rays = kMaxTileRays;
  for (int ray = 0; ray < kMaxTileRays; ++ray) {
    const float u = 2 * random.NextFloat() - 1;
    const float v = 2 * random.NextFloat() - 1;
    SetRay(*cameras_[random.NextBelow(kNumCameras)], u, v, ray, &rays_);
    depth_[ray] = SphereRoomDepth(rays_, ray);
    const Eigen::Vector3f point =
        Row(rays_.origin, ray) + depth_[ray] * Row(rays_.direction, ray);
    for (int channel = 0; channel < 3; ++channel) {
      color_[channel][ray] = 0.1f + 0.8f * Wave(4 * point[channel]) *
                                        Wave(6 * point[(channel + 1) % 3]);
    }
  }
  *rays = rays_;
}

LossValues SphereRoomObjective::Evaluate(const RayOutputs& outputs,
                                         RayGradients* gradients) {
  LossValues losses = {};
  const float share = 1.0f / 1024;
  for (int ray = 0; ray < rays_.num_rays; ++ray) {
    for (int channel = 0; channel < 3; ++channel) {
      const float difference =
          outputs.color[channel][ray] - color_[channel][ray];
      losses[0] += share * difference * difference;
      gradients->d_color[channel][ray] = 2 * share * difference;
    }
    const float difference = outputs.depth[ray] / depth_[ray] - 1;
    losses[1] += share * difference * difference;
    gradients->d_depth[ray] = 2 * share * difference / depth_[ray];
    if (ray % 4 == 0) {
      gradients->pull[ray] = share;
      gradients->pull_z[ray] = depth_[ray];
    }
  }
  return losses;
}

std::vector<std::unique_ptr<TileObjective>> SphereRoomObjectives(
    const RenderEngine& engine) {
  std::vector<std::unique_ptr<TileObjective>> objectives;
  for (int i = 0; i < engine.NumThreads(); ++i) {
    objectives.push_back(std::make_unique<SphereRoomObjective>());
  }
  return objectives;
}

Scene SphereRoomScene() {
  constexpr int kWidth = 640;
  constexpr int kHeight = 480;
  constexpr int kPointDistance = 64;  // in pixels
  constexpr double kFocalLength = 0.5 * kWidth / kTanHalfFov;
  Scene scene;
  for (int i = 0; i < kNumCameras; ++i) {
    const SphereRoomCamera camera(i);
    View view;
    view.camera = {kWidth,
                   kHeight,
                   kFocalLength,
                   kFocalLength,
                   0.5 * kWidth,
                   0.5 * kHeight};
    view.cam_from_world_rotation = camera.axes.transpose().cast<double>();
    view.cam_from_world_translation =
        -view.cam_from_world_rotation * camera.center.cast<double>();
    scene.views.push_back(view);
    for (int y = kPointDistance / 2; y < kHeight; y += kPointDistance) {
      for (int x = kPointDistance / 2; x < kWidth; x += kPointDistance) {
        RayTile rays;
        SetRay(camera,
               static_cast<float>((x - view.camera.cx) /
                                  (kFocalLength * kTanHalfFov)),
               static_cast<float>((y - view.camera.cy) /
                                  (kFocalLength * kTanHalfFov)),
               0,
               &rays);
        SparsePoint point;
        point.xyz = (Row(rays.origin, 0) +
                     SphereRoomDepth(rays, 0) * Row(rays.direction, 0))
                        .cast<double>();
        point.track.push_back({i, Eigen::Vector2d(x, y)});
        scene.points.push_back(point);
      }
    }
  }
  return scene;
}

std::vector<RayTile> SphereRoomView(const int width, const int height) {
  const SphereRoomCamera camera(0);
  std::vector<RayTile> tiles;
  for (int row = 0; row < height; ++row) {
    for (int col = 0; col < width; ++col) {
      if (tiles.empty() || tiles.back().num_rays == kMaxTileRays) {
        tiles.emplace_back();
      }
      RayTile& tile = tiles.back();
      SetRay(camera,
             2 * (col + 0.5f) / width - 1,
             2 * (row + 0.5f) / height - 1,
             tile.num_rays++,
             &tile);
    }
  }
  return tiles;
}

}  // namespace structnerf
