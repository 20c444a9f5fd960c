#include "tests/nerf/plane_scene.h"

#include <cmath>

#include <Eigen/Geometry>

namespace structnerf {

double TexturedPlane::Gray(const Eigen::Vector3d& x_in_world) const {
  const Eigen::Vector3d u = normal.unitOrthogonal();
  const Eigen::Vector3d v = normal.normalized().cross(u);
  const Eigen::Vector3d offset = (x_in_world - point) * (2 * M_PI / wavelength);
  const double a = offset.dot(u);
  const double b = offset.dot(v);
  return 0.5 + 0.13 * std::sin(a + 0.3) + 0.13 * std::sin(b + 1.1) +
         0.14 * std::sin(0.37 * a + 0.21 * b);
}

double TexturedPlane::Depth(const View& view,
                            const double x,
                            const double y) const {
  const PinholeCamera& camera = view.camera;
  const Eigen::Vector3d ray(
      (x - camera.cx) / camera.fx, (y - camera.cy) / camera.fy, 1.0);
  const Eigen::Vector3d direction =
      view.cam_from_world_rotation.transpose() * ray;
  return normal.dot(point - view.ProjectionCenter()) / normal.dot(direction);
}

DenseMaps TexturedPlane::DepthMap(const View& view, const double factor) const {
  DenseMaps maps;
  maps.width = view.camera.width;
  maps.height = view.camera.height;
  for (int row = 0; row < maps.height; ++row) {
    for (int col = 0; col < maps.width; ++col) {
      maps.depth.push_back(static_cast<float>(factor * Depth(view, col, row)));
    }
  }
  return maps;
}

Eigen::Vector3d TexturedPlane::NormalInView(const View& view) const {
  const Eigen::Vector3d in_view =
      (view.cam_from_world_rotation * normal).normalized();
  const double side = normal.dot(view.ProjectionCenter() - point);
  return side > 0 ? in_view : Eigen::Vector3d(-in_view);
}

void TexturedPlane::Photograph(const int width,
                               const int height,
                               View* view) const {
  const PinholeCamera& camera = view->camera;
  view->image = PlainImage(width, height, 0);
  for (int row = 0; row < height; ++row) {
    for (int col = 0; col < width; ++col) {
      const double x = (col + 0.5) * camera.width / width;
      const double y = (row + 0.5) * camera.height / height;
      const double gray = Gray(Unproject(*view, x, y, Depth(*view, x, y)));
      for (int c = 0; c < 3; ++c) {
        view->image.data[3 * (static_cast<size_t>(row) * width + col) + c] =
            static_cast<uint8_t>(255 * gray + 0.5);
      }
    }
  }
}

PinholeCamera MakeCamera(const int width,
                         const int height,
                         const double focal_length) {
  return {width, height, focal_length, focal_length, 0.5 * width, 0.5 * height};
}

View MakeView(const std::string& name,
              const PinholeCamera& camera,
              const Eigen::Vector3d& center,
              const Eigen::Vector3d& direction) {
  const Eigen::Vector3d z = direction.normalized();
  Eigen::Vector3d x = Eigen::Vector3d(0, 1, 0).cross(z);
  x = x.norm() > 1e-9 ? Eigen::Vector3d(x.normalized())
                      : Eigen::Vector3d::UnitX();
  View view;
  view.name = name;
  view.camera = camera;
  view.cam_from_world_rotation.row(0) = x;
  view.cam_from_world_rotation.row(1) = z.cross(x);
  view.cam_from_world_rotation.row(2) = z;
  view.cam_from_world_translation = -(view.cam_from_world_rotation * center);
  return view;
}

SparsePoint MakePoint(const Scene& scene,
                      const Eigen::Vector3d& xyz,
                      const std::vector<int>& view_idxs,
                      const double error) {
  SparsePoint point;
  point.xyz = xyz;
  point.error = error;
  for (const int view_idx : view_idxs) {
    point.track.push_back(
        {view_idx, Project(scene.views[view_idx], xyz).head<2>()});
  }
  return point;
}

Eigen::Vector3d Project(const View& view, const Eigen::Vector3d& xyz) {
  const Eigen::Vector3d in_view = view.CamFromWorld(xyz);
  return Eigen::Vector3d(
      view.camera.fx * in_view.x() / in_view.z() + view.camera.cx,
      view.camera.fy * in_view.y() / in_view.z() + view.camera.cy,
      in_view.z());
}

Eigen::Vector3d Unproject(const View& view,
                          const double x,
                          const double y,
                          const double depth) {
  const PinholeCamera& camera = view.camera;
  return view.WorldFromCam({depth * (x - camera.cx) / camera.fx,
                            depth * (y - camera.cy) / camera.fy,
                            depth});
}

RgbImage PlainImage(const int width, const int height, const uint8_t value) {
  RgbImage image;
  image.width = width;
  image.height = height;
  image.data.assign(3 * static_cast<size_t>(width) * height, value);
  return image;
}

}  // namespace structnerf
