#pragma once

#include "nerf/scene.h"

#include <cstddef>
#include <cstdint>
#include <vector>

#include <opencv2/core.hpp>

namespace structnerf {

// Plane mean deviation (paper, section IV-A): the mean distance of the
// back-projected pixels of planar regions to the plane fitted to each region.
// The paper does not say which regions; here they are those that it regularises
// (section III-C), superpixels of more than 1000 pixels.
class PlaneDeviation {
 public:
  // `depth` in metres, 0 = none; the value of (col, row) belongs to the image
  // point (col + offset, row + offset) of `camera`. `labels`: one per pixel, -1
  // = in no region. Regions with depth at fewer than half of their pixels are
  // left out.
  void AddView(const PinholeCamera& camera,
               double offset,
               const std::vector<int32_t>& labels,
               const cv::Mat1f& depth);

  // Metres; 0 if no plane was found.
  double Mean() const;
  size_t NumPlanes() const { return num_planes_; }
  size_t NumPoints() const { return num_points_; }

 private:
  double sum_ = 0;
  size_t num_points_ = 0;
  size_t num_planes_ = 0;
};

// Labels of the planar regions of a photograph (8-bit BGR) for AddView.
std::vector<int32_t> FindPlanarRegions(const cv::Mat3b& image);

}  // namespace structnerf
