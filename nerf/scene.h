#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace structnerf {

// Undistorted pinhole camera. Image coordinates follow COLMAP: the centre of
// the first pixel is (0.5, 0.5), so the image covers [0, width] x [0, height].
struct PinholeCamera {
  int width = 0;   // pixels
  int height = 0;  // pixels
  double fx = 0;   // pixels, > 0
  double fy = 0;   // pixels, > 0
  double cx = 0;   // pixels
  double cy = 0;   // pixels

  // The same camera with another image size over the same field of view.
  PinholeCamera Resized(int new_width, int new_height) const;

  // The same camera with at most `max_size` pixels along its longer side.
  PinholeCamera Reduced(int max_size) const;

  size_t NumPixels() const { return static_cast<size_t>(width) * height; }

  // From the camera frame to homogeneous image points.
  Eigen::Matrix3d CalibrationMatrix() const;
};

// 8-bit interleaved RGB, row-major, no padding.
struct RgbImage {
  int width = 0;
  int height = 0;
  std::vector<uint8_t> data;  // 3 * width * height
};

// How a photograph shows the colours of the scene, per channel: photograph =
// gain * colour + offset, both in [0, 1].
struct Exposure {
  Eigen::Vector3f gain = Eigen::Vector3f::Ones();  // > 0
  Eigen::Vector3f offset = Eigen::Vector3f::Zero();

  Eigen::Vector3f Apply(const Eigen::Vector3f& color) const {
    return gain.cwiseProduct(color) + offset;
  }
};

// One registered photograph. Camera axes: x right, y down, z forward.
struct View {
  // Path below the image folder, as in the COLMAP model.
  std::string name;

  // Camera of the undistorted photograph; the maps of this view have its size.
  PinholeCamera camera;

  // See CamFromWorld().
  Eigen::Matrix3d cam_from_world_rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d cam_from_world_translation = Eigen::Vector3d::Zero();

  // The photograph at training resolution: at most the camera's size, covering
  // the same field of view.
  RgbImage image;

  // Of `image`, relative to the mean of the scene.
  Exposure exposure;

  // Same size as `image`, or empty if nothing is masked; 0 = ignore the pixel.
  std::vector<uint8_t> mask;

  // Same size as `image`, or empty. Label of the superpixel if it is large
  // enough to be taken for a plane (paper, section III-C), else -1.
  std::vector<int32_t> segments;

  // Depth that is known from elsewhere (stereo, a depth completion network) and
  // its standard deviation, same size as `image`, or empty: z-depth in world
  // units, 0 = none. Deviations may be empty where depths are not, if they are
  // unknown.
  std::vector<float> prior_depth;
  std::vector<float> prior_deviation;

  // z-depths, world units, between which rays are sampled, same size as
  // `image`, or empty; 0 = the whole ray.
  std::vector<float> near_depth;
  std::vector<float> far_depth;

  // A point in world coordinates, in the camera's frame, world units:
  // cam_from_world_rotation * x_in_world + cam_from_world_translation.
  Eigen::Vector3d CamFromWorld(const Eigen::Vector3d& x_in_world) const;

  // The way back.
  Eigen::Vector3d WorldFromCam(const Eigen::Vector3d& x_in_cam) const;

  // World coordinates.
  Eigen::Vector3d ProjectionCenter() const;

  // The camera of `image`; `camera` if that is not loaded.
  PinholeCamera ImageCamera() const;
};

// Name, camera, pose and exposure of a view, without its pixels.
View PoseOf(const View& view);

// Where a sparse point was found in a view.
struct Observation {
  int view_idx = -1;   // into Scene::views
  Eigen::Vector2d xy;  // in `View::camera`'s image coordinates
};

// A triangulated point of the sparse model.
struct SparsePoint {
  Eigen::Vector3d xyz = Eigen::Vector3d::Zero();  // world
  double error = -1;  // mean reprojection error in pixels; -1 = unknown
  std::vector<Observation> track;
};

// Everything the method sees of a COLMAP model. World units and frame are
// those of the model.
struct Scene {
  std::vector<View> views;
  std::vector<SparsePoint> points;

  // Throws std::invalid_argument, naming the view or point, if sizes, indices
  // or numbers contradict what is documented above.
  void Check() const;
};

}  // namespace structnerf
