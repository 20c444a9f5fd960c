#pragma once

#include "nerf/planes/plane_view.h"

#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

namespace structnerf {

// A reliable pixel in or around a segment.
struct Anchor {
  Eigen::Vector3f ray;
  float rho = 0;
  bool is_inside = false;
  bool is_inner = false;  // farther from the border than matches may be off
};

// What is known of a superpixel. Rows and columns are those of its pixels.
struct Segment {
  int min_col = 1 << 30;
  int max_col = -1;
  int min_row = 1 << 30;
  int max_row = -1;
  size_t num_inner = 0;                // pixels as far from the border
  size_t num_anchors = 0;              // all that were seen
  std::vector<Anchor> anchors;         // a random choice of them
  std::vector<uint32_t> blank_pixels;  // without reliable depth
};

// The segments of a view, by label. `border`: how far, in pixels, anchors may
// be outside of their segment, at least 2. `view_idx` seeds the random choice.
std::vector<Segment> CollectSegments(const PlaneView& view,
                                     int border,
                                     int view_idx);

}  // namespace structnerf
