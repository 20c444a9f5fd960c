#include "tests/nerf/planes/room_scene.h"

#include "tests/nerf/plane_scene.h"

#include <cmath>

namespace structnerf {

Hit Look(const View& view, const double x, const double y) {
  const PinholeCamera& camera = view.camera;
  const Eigen::Vector3d center = view.ProjectionCenter();
  const Eigen::Vector3d direction =
      view.cam_from_world_rotation.transpose() *
      Eigen::Vector3d(
          (x - camera.cx) / camera.fx, (y - camera.cy) / camera.fy, 1);
  const double to_wall = (5 - center.z()) / direction.z();
  const double to_floor = (1 - center.y()) / direction.y();
  Hit hit;
  if (to_floor > 0 && to_floor < to_wall) {
    hit.surface = Surface::kFloor;
    hit.depth = to_floor;
    hit.normal = view.cam_from_world_rotation * -Eigen::Vector3d::UnitY();
    return hit;
  }
  const Eigen::Vector3d on_wall = center + to_wall * direction;
  if (on_wall.y() < -1) {
    return hit;
  }
  hit.depth = to_wall;
  hit.normal = view.cam_from_world_rotation * -Eigen::Vector3d::UnitZ();
  if (std::abs(on_wall.x()) > 1.6 || std::abs(on_wall.y()) > 0.6) {
    hit.surface = Surface::kWall;
  } else if (std::abs(on_wall.x() - 0.4) < 0.2 && std::abs(on_wall.y()) < 0.2) {
    hit.surface = Surface::kPicture;
  } else {
    hit.surface = Surface::kBlank;
  }
  return hit;
}

Surface SurfaceOfMapPixel(const View& view, const size_t index) {
  return Look(view,
              static_cast<double>(index % view.camera.width),
              static_cast<double>(index / view.camera.width))
      .surface;
}

Room MakeRoom(const int camera_width, const int image_width) {
  Room room;
  room.frame.origin = Eigen::Vector3d(-3, -2, -1);
  room.frame.scale = 0.125;
  const int camera_height = camera_width * 3 / 4;
  const int image_height = image_width * 3 / 4;
  for (int v = 0; v < 5; ++v) {
    View view =
        MakeView("view",
                 MakeCamera(camera_width, camera_height, 0.9 * camera_width),
                 Eigen::Vector3d(0.4 * (v - 2), v % 2 * 0.3 - 0.2, 0.1 * v),
                 Eigen::Vector3d(-0.06 * (v - 2), 0.2, 1));
    view.image = PlainImage(image_width, image_height, 128);
    View resized = view;
    resized.camera = view.camera.Resized(image_width, image_height);
    for (int row = 0; row < image_height; ++row) {
      for (int col = 0; col < image_width; ++col) {
        const Surface surface = Look(resized, col + 0.5, row + 0.5).surface;
        const bool is_in_segment =
            surface == Surface::kBlank || surface == Surface::kPicture;
        view.segments.push_back(is_in_segment ? 0 : -1);
      }
    }
    DenseMaps maps;
    maps.width = camera_width;
    maps.height = camera_height;
    const size_t num_pixels = static_cast<size_t>(camera_width) * camera_height;
    maps.normal.resize(3 * num_pixels);
    DenseMaps wrong_maps = maps;
    for (size_t i = 0; i < num_pixels; ++i) {
      const Hit hit = Look(view,
                           static_cast<double>(i % camera_width),
                           static_cast<double>(i / camera_width));
      const bool is_blank = hit.surface == Surface::kBlank;
      maps.depth.push_back(static_cast<float>(hit.depth));
      maps.distinctness.push_back(is_blank ? 0.0f : 0.5f);
      // Each view errs by another amount, and by the plane of the image.
      wrong_maps.depth.push_back(
          static_cast<float>(hit.depth * (is_blank ? 0.85 - 0.03 * v : 1)));
      for (int axis = 0; axis < 3; ++axis) {
        maps.normal[axis * num_pixels + i] =
            static_cast<float>(hit.normal[axis]);
        wrong_maps.normal[axis * num_pixels + i] = static_cast<float>(
            is_blank ? -Eigen::Vector3d::UnitZ()[axis] : hit.normal[axis]);
      }
    }
    wrong_maps.distinctness = maps.distinctness;
    room.scene.views.push_back(view);
    room.truth.push_back(maps);
    room.maps.push_back(wrong_maps);
    std::vector<int> sources;
    for (int other = 0; other < 5; ++other) {
      if (other != v) {
        sources.push_back(other);
      }
    }
    room.sources.push_back(sources);
  }
  return room;
}

}  // namespace structnerf
