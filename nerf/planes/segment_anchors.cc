#include "nerf/planes/segment_anchors.h"

#include "nerf/util/random.h"

#include <algorithm>

namespace structnerf {
namespace {

// Anchors that are kept per segment.
constexpr size_t kMaxAnchors = 800;

// The labels on a lattice of points up to `border` away from a pixel.
struct Surroundings {
  std::vector<int32_t> labels;  // each once, those of segments only
  bool is_inner = true;         // all are the pixel's own
};

void LookAround(const PlaneView& view,
                const int border,
                const int col,
                const int row,
                Surroundings* around) {
  const int32_t label = view.segments[view.Index(col, row)];
  const int offsets[] = {-border, -border / 2, 0, border / 2, border};
  around->labels.clear();
  around->is_inner = true;
  for (const int dy : offsets) {
    for (const int dx : offsets) {
      const int x = col + dx;
      const int y = row + dy;
      const bool is_in_image =
          x >= 0 && y >= 0 && x < view.width && y < view.height;
      const int32_t other = is_in_image ? view.segments[view.Index(x, y)] : -1;
      around->is_inner = around->is_inner && other == label;
      if (other >= 0 &&
          std::count(around->labels.begin(), around->labels.end(), other) ==
              0) {
        around->labels.push_back(other);
      }
    }
  }
}

void AddPixel(const int col, const int row, Segment* segment) {
  segment->min_col = std::min(segment->min_col, col);
  segment->max_col = std::max(segment->max_col, col);
  segment->min_row = std::min(segment->min_row, row);
  segment->max_row = std::max(segment->max_row, row);
}

// Keeps a random choice of all anchors.
void AddAnchor(const Anchor& anchor, Random* random, Segment* segment) {
  if (segment->anchors.size() < kMaxAnchors) {
    segment->anchors.push_back(anchor);
  } else {
    const uint32_t place =
        random->NextBelow(static_cast<uint32_t>(segment->num_anchors + 1));
    if (place < kMaxAnchors) {
      segment->anchors[place] = anchor;
    }
  }
  ++segment->num_anchors;
}

}  // namespace

std::vector<Segment> CollectSegments(const PlaneView& view,
                                     const int border,
                                     const int view_idx) {
  const auto max_label =
      std::max_element(view.segments.begin(), view.segments.end());
  std::vector<Segment> segments(
      max_label == view.segments.end() ? 0 : *max_label + 1);
  Random random(view_idx);
  Surroundings around;
  for (int row = 0; row < view.height; ++row) {
    for (int col = 0; col < view.width; ++col) {
      const size_t index = view.Index(col, row);
      const int32_t label = view.segments[index];
      const bool is_reliable = view.is_reliable[index] != 0;
      if (!is_reliable && label < 0) {
        continue;
      }
      LookAround(view, border, col, row, &around);
      if (label >= 0) {
        Segment& segment = segments[label];
        AddPixel(col, row, &segment);
        segment.num_inner += around.is_inner;
        if (!is_reliable) {
          segment.blank_pixels.push_back(static_cast<uint32_t>(index));
        }
      }
      if (!is_reliable) {
        continue;
      }
      for (const int32_t other : around.labels) {
        AddAnchor({view.Ray(col, row),
                   view.rho[index],
                   other == label,
                   other == label && around.is_inner},
                  &random,
                  &segments[other]);
      }
    }
  }
  return segments;
}

}  // namespace structnerf
