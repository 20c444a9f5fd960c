#include "nerf/stereo/depth_refinement.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Core>

namespace structnerf {
namespace {

// The plane of one pixel of the maps, as inverse depth and slopes in the
// camera's image coordinates.
struct ImagePlane {
  double rho;
  double rho_x;
  double rho_y;
};

Eigen::Vector3d RayDirection(const PinholeCamera& camera,
                             const double x,
                             const double y) {
  return {(x - camera.cx) / camera.fx, (y - camera.cy) / camera.fy, 1.0};
}

// rho(x, y) = n . ray(x, y) / d for the plane n . X = d. Without a depth, rho
// is zero; without a normal that faces the camera, the plane is that of the
// image.
ImagePlane PlaneOfPixel(const PinholeCamera& camera,
                        const DenseMaps& maps,
                        const int col,
                        const int row) {
  const size_t num_pixels = static_cast<size_t>(maps.width) * maps.height;
  const size_t index = static_cast<size_t>(row) * maps.width + col;
  const Eigen::Vector3d normal(maps.normal[index],
                               maps.normal[num_pixels + index],
                               maps.normal[2 * num_pixels + index]);
  if (!(maps.depth[index] > 0)) {
    return {0, 0, 0};
  }
  const double rho = 1.0 / maps.depth[index];
  const double facing = normal.dot(RayDirection(camera, col, row));
  if (!(facing < 0)) {
    return {rho, 0, 0};
  }
  const double scale = rho / facing;
  return {rho, normal.x() * scale / camera.fx, normal.y() * scale / camera.fy};
}

void SetPlaneOfPixel(const PinholeCamera& camera,
                     const ImagePlane& plane,
                     const int col,
                     const int row,
                     DenseMaps* maps) {
  const size_t num_pixels = static_cast<size_t>(maps->width) * maps->height;
  const size_t index = static_cast<size_t>(row) * maps->width + col;
  const double by_x = plane.rho_x * camera.fx;
  const double by_y = plane.rho_y * camera.fy;
  const Eigen::Vector3d ray = RayDirection(camera, col, row);
  // rho = by_x ray_x + by_y ray_y + constant.
  const Eigen::Vector3d normal =
      -Eigen::Vector3d(by_x, by_y, plane.rho - by_x * ray.x() - by_y * ray.y())
           .normalized();
  maps->depth[index] = static_cast<float>(1.0 / plane.rho);
  for (int i = 0; i < 3; ++i) {
    maps->normal[i * num_pixels + index] = static_cast<float>(normal[i]);
  }
}

}  // namespace

PlaneMaps PlanesOfMaps(const View& view,
                       const SceneFrame& frame,
                       const TrainingViews::Image& image,
                       ThreadPool* pool,
                       const DenseMaps& maps) {
  const PinholeCamera& camera = view.camera;
  const double ratio_x = static_cast<double>(camera.width) / image.width;
  const double ratio_y = static_cast<double>(camera.height) / image.height;
  PlaneMaps planes;
  planes.width = image.width;
  planes.height = image.height;
  const size_t num_pixels = static_cast<size_t>(image.width) * image.height;
  planes.rho.resize(num_pixels);
  planes.rho_x.resize(num_pixels);
  planes.rho_y.resize(num_pixels);
  pool->ParallelFor(image.height, [&](const size_t row, int) {
    for (int col = 0; col < image.width; ++col) {
      const double x = (col + 0.5) * ratio_x;
      const double y = (static_cast<double>(row) + 0.5) * ratio_y;
      const int map_col = std::min(static_cast<int>(x), camera.width - 1);
      const int map_row = std::min(static_cast<int>(y), camera.height - 1);
      const ImagePlane plane = PlaneOfPixel(camera, maps, map_col, map_row);
      const double rho =
          plane.rho + (x - map_col) * plane.rho_x + (y - map_row) * plane.rho_y;
      const size_t index = row * image.width + col;
      planes.rho[index] = static_cast<float>(rho / frame.scale);
      planes.rho_x[index] =
          static_cast<float>(plane.rho_x * ratio_x / frame.scale);
      planes.rho_y[index] =
          static_cast<float>(plane.rho_y * ratio_y / frame.scale);
    }
  });
  return planes;
}

void RefineDepth(const View& view,
                 const int view_idx,
                 const SceneFrame& frame,
                 const TrainingViews::Image& image,
                 const PatchMatch& patch_match,
                 ThreadPool* pool,
                 Progress* progress,
                 DenseMaps* maps) {
  const PinholeCamera& camera = view.camera;
  // Camera pixels per pixel of the matched image.
  const double ratio_x = static_cast<double>(camera.width) / image.width;
  const double ratio_y = static_cast<double>(camera.height) / image.height;

  PlaneMaps planes = PlanesOfMaps(view, frame, image, pool, *maps);
  patch_match.Refine(view_idx, pool, progress, &planes);

  maps->distinctness.assign(maps->depth.size(), 0.0f);
  pool->ParallelFor(camera.height, [&](const size_t map_row, int) {
    for (int map_col = 0; map_col < camera.width; ++map_col) {
      if (!(maps->depth[map_row * camera.width + map_col] > 0)) {
        continue;
      }
      const int col =
          std::min(static_cast<int>(map_col / ratio_x), image.width - 1);
      const int row =
          std::min(static_cast<int>(static_cast<double>(map_row) / ratio_y),
                   image.height - 1);
      const size_t index = static_cast<size_t>(row) * image.width + col;
      // No better than without texture: it is still the seed.
      if (!(planes.cost[index] < 1)) {
        continue;
      }
      ImagePlane plane;
      plane.rho_x = planes.rho_x[index] * frame.scale / ratio_x;
      plane.rho_y = planes.rho_y[index] * frame.scale / ratio_y;
      plane.rho =
          planes.rho[index] * frame.scale +
          (map_col - (col + 0.5) * ratio_x) * plane.rho_x +
          (static_cast<double>(map_row) - (row + 0.5) * ratio_y) * plane.rho_y;
      if (plane.rho > 0) {
        SetPlaneOfPixel(
            camera, plane, map_col, static_cast<int>(map_row), maps);
        maps->distinctness[map_row * camera.width + map_col] =
            planes.distinctness[index];
      }
    }
  });
}

}  // namespace structnerf
