#include "tests/nerf/train/objective_scene.h"

#include <cmath>
#include <limits>

#include <Eigen/LU>

namespace structnerf {
namespace {

constexpr int kWidth = 24;
constexpr int kHeight = 18;

}  // namespace

ObjectiveScene::ObjectiveScene() {
  plane.normal = {0.15, -0.1, -1};
  plane.wavelength = 1.2;
  const Eigen::Vector3d centers[] = {
      {0, 0, 0}, {0.3, 0, 0.1}, {-0.2, 0.25, 0}, {0.1, -0.3, -0.1}};
  for (const Eigen::Vector3d& center : centers) {
    // Cameras larger than their images.
    View view = MakeView("view", MakeCamera(48, 36, 50), center);
    plane.Photograph(kWidth, kHeight, &view);
    // The left half is one superpixel, some of the right another.
    view.segments.assign(kWidth * kHeight, -1);
    for (int row = 0; row < kHeight; ++row) {
      for (int col = 0; col < kWidth; ++col) {
        if (col < kWidth / 2) {
          view.segments[row * kWidth + col] = 3;
        } else if (col > 15 && row > 5) {
          view.segments[row * kWidth + col] = 8;
        }
      }
    }
    scene.views.push_back(view);
  }
  for (int i = 0; i < 40; ++i) {
    AddPoint(0.371 * (i % 8) - 1.289, 0.473 * (i / 8) - 0.967, 0.5 + 0.02 * i);
  }
  frame = ComputeSceneFrame(scene);
  loss.color_weight = 1;
  loss.patch_weight = 1;
  loss.planar_weight = 0.1;
  loss.sparse_weight = 1;
  loss.prior_weight = 0.1;
  training.num_steps = 100;
  // No single pixels are held out.
  training.test_every = 8;
  training.rays_per_step = 256;
}

TrainingObjective ObjectiveScene::MakeObjective() const {
  std::vector<std::vector<int>> sources(scene.views.size());
  for (int v = 0; v < static_cast<int>(scene.views.size()); ++v) {
    for (const int source : train_view_idxs) {
      if (source != v) {
        sources[v].push_back(source);
      }
    }
  }
  return TrainingObjective(
      scene, frame, train_view_idxs, sources, loss, training);
}

bool ObjectiveScene::ImagePoint::IsPixelCenter() const {
  return std::abs(x - Col() - 0.5) < 1e-3 && std::abs(y - Row() - 0.5) < 1e-3;
}

ObjectiveScene::ImagePoint ObjectiveScene::Identify(const RayTile& rays,
                                                    const int ray) const {
  const Eigen::Vector3d origin(
      rays.origin[0][ray], rays.origin[1][ray], rays.origin[2][ray]);
  const Eigen::Vector3d direction(
      rays.direction[0][ray], rays.direction[1][ray], rays.direction[2][ray]);
  ImagePoint point;
  double nearest = std::numeric_limits<double>::max();
  for (size_t v = 0; v < scene.views.size(); ++v) {
    const View& view = scene.views[v];
    const double distance =
        (frame.FieldFromWorld(view.ProjectionCenter()) - origin).norm();
    if (distance < nearest) {
      nearest = distance;
      const PinholeCamera camera = view.ImageCamera();
      const Eigen::Vector3d in_view = view.cam_from_world_rotation * direction;
      point.view_idx = static_cast<int>(v);
      point.x = camera.fx * in_view.x() / in_view.z() + camera.cx;
      point.y = camera.fy * in_view.y() / in_view.z() + camera.cy;
    }
  }
  return point;
}

double ObjectiveScene::TrueDepth(const ImagePoint& point) const {
  const View& view = scene.views[point.view_idx];
  return frame.scale * plane.Depth(view,
                                   point.x * view.camera.width / kWidth,
                                   point.y * view.camera.height / kHeight);
}

RayOutputs ObjectiveScene::TrueOutputs(const RayTile& rays) const {
  RayOutputs outputs = {};
  for (int ray = 0; ray < rays.num_rays; ++ray) {
    const ImagePoint point = Identify(rays, ray);
    outputs.depth[ray] = static_cast<float>(TrueDepth(point));
    outputs.opacity[ray] = 1;
    const View& view = scene.views[point.view_idx];
    for (int c = 0; c < 3; ++c) {
      outputs.color[c][ray] =
          view.image.data[3 * (point.Row() * kWidth + point.Col()) + c] /
          255.0f;
    }
  }
  return outputs;
}

void ObjectiveScene::MakeFrontal() {
  plane.normal = {0, 0, -1};
  for (View& view : scene.views) {
    view.cam_from_world_translation.z() = 0;
  }
  scene.points.clear();
  AddPoint(0.1, 0.2, 1);
}

void ObjectiveScene::AddPoint(const double x,
                              const double y,
                              const double error) {
  // On the wall, whose equation is normal . (X - point) = 0.
  const double z =
      plane.point.z() -
      (plane.normal.x() * x + plane.normal.y() * y) / plane.normal.z();
  scene.points.push_back(MakePoint(scene, {x, y, z}, {0, 1, 2, 3}, error));
}

void ObjectiveScene::AddPrior(const float factor) {
  View& view = scene.views[1];
  for (int row = 0; row < kHeight; ++row) {
    for (int col = 0; col < kWidth; ++col) {
      view.prior_depth.push_back(
          factor * static_cast<float>(TrueDepth({1, col + 0.5, row + 0.5}) /
                                      frame.scale));
    }
  }
  view.prior_deviation.assign(view.prior_depth.size(), 1e-3f);
}

}  // namespace structnerf
