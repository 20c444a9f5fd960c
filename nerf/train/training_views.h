#pragma once

#include "nerf/engine/ray_tile.h"
#include "nerf/scene.h"
#include "nerf/scene_frame.h"

#include <cstdint>
#include <vector>

#include <Eigen/Core>

namespace structnerf {

// Pose and intrinsics of a view in field coordinates, for rays.
class ViewGeometry {
 public:
  // `camera` may be the view's own or a resized one.
  ViewGeometry(const View& view,
               const PinholeCamera& camera,
               const SceneFrame& frame);

  // Writes the ray through image point (x, y) of `camera` as ray `ray` of the
  // tile. Rays end where they leave the scene box, or are limited to the view's
  // bounds of depth.
  void SetRay(double x, double y, int ray, RayTile* rays) const;

 private:
  Eigen::Vector3d center_;            // field coordinates
  Eigen::Matrix3d field_from_pixel_;  // direction of unit depth from (x, y, 1)
  Eigen::Vector3d extent_;
  double near_;

  // Bounds of depth of the view's image, field units, 0 = none; empty if there
  // are none at all.
  struct Bounds {
    float near = 0;
    float far = 0;
  };
  std::vector<Bounds> bounds_;
  int bounds_width_ = 0;
  int bounds_height_ = 0;
  double bounds_per_x_ = 0;  // pixels of the image per pixel of `camera`
  double bounds_per_y_ = 0;
};

// Pixels that all images to train on may have together: byte offsets of grey
// values are 32 bits wide.
constexpr size_t kMaxTrainingPixels = (size_t{1} << 30) - 1;

// All photographs at training resolution, packed for random access from many
// threads.
class TrainingViews {
 public:
  struct Image {
    int width = 0;
    int height = 0;
    size_t first_pixel = 0;  // into Color() and Grays()
  };

  // Throws std::invalid_argument if they have more than kMaxTrainingPixels.
  TrainingViews(const Scene& scene, const SceneFrame& frame);

  size_t size() const { return images_.size(); }
  const Image& image(const int view_idx) const { return images_[view_idx]; }
  const ViewGeometry& geometry(const int view_idx) const {
    return geometries_[view_idx];
  }

  const Exposure& exposure(const int view_idx) const {
    return exposures_[view_idx];
  }

  // Colour of a pixel, channels in [0, 1].
  Eigen::Vector3f Color(int view_idx, int col, int row) const;

  // Masked pixels (scene masks) are neither drawn nor compared with.
  bool IsMasked(int view_idx, int col, int row) const;

  // Grey values, 0 to kMaxGray, all images one after another, row-major, and
  // padding that makes a read of two values valid at any pixel. Masked pixels
  // are kMaskedGray.
  static constexpr int kMaxGray = 65534;
  static constexpr int kMaskedGray = 65535;
  const uint16_t* Grays() const { return grays_.data(); }

 private:
  std::vector<Image> images_;
  std::vector<ViewGeometry> geometries_;
  std::vector<Exposure> exposures_;
  std::vector<uint32_t> colors_;  // 0x00BBGGRR
  std::vector<uint16_t> grays_;
};

}  // namespace structnerf
