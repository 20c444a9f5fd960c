#pragma once

#include "nerf/dense_maps.h"
#include "nerf/scene.h"
#include "nerf/scene_frame.h"

#include <cstddef>
#include <vector>

#include <Eigen/Core>

namespace structnerf {

// What a ray meets in a room with a floor and a wall that ends above.
enum class Surface { kNothing, kFloor, kWall, kPicture, kBlank };

struct Hit {
  Surface surface = Surface::kNothing;
  double depth = 0;
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  // camera frame
};

// Through an image point of the view's camera.
Hit Look(const View& view, double x, double y);

// Of the value with that index in the view's maps.
Surface SurfaceOfMapPixel(const View& view, size_t index);

struct Room {
  Scene scene;
  std::vector<std::vector<int>> sources;
  SceneFrame frame;
  std::vector<DenseMaps> truth;
  std::vector<DenseMaps> maps;  // the blank wall is too near
};

// Five views, whose photographs are smaller than the cameras. The blank part of
// the wall, with its picture, is segment 0. The rest matches everywhere.
Room MakeRoom(int camera_width, int image_width);

}  // namespace structnerf
