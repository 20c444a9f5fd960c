#pragma once

#include "nerf/dense_maps.h"
#include "nerf/scene.h"

#include <string>

#include <Eigen/Core>

namespace structnerf {

// A plane with a smooth analytic texture. Every camera sees it as it is, so
// depth, normal and grey value of every image point are known.
struct TexturedPlane {
  Eigen::Vector3d point = Eigen::Vector3d(0, 0, 4);    // world
  Eigen::Vector3d normal = Eigen::Vector3d(0, 0, -1);  // any length

  // Of the shortest wave of the texture, world units.
  double wavelength = 0.4;

  // In [0.1, 0.9].
  double Gray(const Eigen::Vector3d& x_in_world) const;

  // z-depth along the ray through an image point of `view.camera`; not positive
  // if the ray does not meet the plane in front of the camera.
  double Depth(const View& view, double x, double y) const;

  // Maps of a view with nothing but depth, off by a factor.
  DenseMaps DepthMap(const View& view, double factor = 1) const;

  // Normal in the camera frame, unit, facing the camera.
  Eigen::Vector3d NormalInView(const View& view) const;

  // Takes the view's photograph, every channel equal, at the given size.
  void Photograph(int width, int height, View* view) const;
};

// Principal point in the middle.
PinholeCamera MakeCamera(int width, int height, double focal_length);

// A view at `center` that looks along `direction`, its x axis as horizontal (in
// world x and z) as can be. It has no image yet.
View MakeView(const std::string& name,
              const PinholeCamera& camera,
              const Eigen::Vector3d& center,
              const Eigen::Vector3d& direction = Eigen::Vector3d(0, 0, 1));

// A sparse point seen by the given views where it projects to.
SparsePoint MakePoint(const Scene& scene,
                      const Eigen::Vector3d& xyz,
                      const std::vector<int>& view_idxs,
                      double error = 0.5);

// Image point and z-depth of a world point.
Eigen::Vector3d Project(const View& view, const Eigen::Vector3d& xyz);

// The other way round.
Eigen::Vector3d Unproject(const View& view, double x, double y, double depth);

// An image of one colour.
RgbImage PlainImage(int width, int height, uint8_t value);

}  // namespace structnerf
