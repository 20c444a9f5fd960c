#pragma once

#include "nerf/losses/view_warp.h"
#include "nerf/planes/plane_view.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace structnerf {

// Square cells over a view, in which planes are chosen.
class PlaneLattice {
 public:
  // Of a view so large, in pixels.
  PlaneLattice(int width, int height);

  int NumCols() const { return num_cols_; }
  int NumRows() const { return num_rows_; }
  size_t NumCells() const { return static_cast<size_t>(num_rows_) * num_cols_; }

  // Of a cell, row-major.
  size_t Index(const int cell_col, const int cell_row) const {
    return static_cast<size_t>(cell_row) * num_cols_ + cell_col;
  }

  // Of the cell that a pixel is in.
  size_t IndexOfPixel(const int col, const int row) const {
    return Index(col / step_, row / step_);
  }

  // The pixel in the middle of a cell, which speaks for those of its segment.
  int CenterCol(int cell_col) const;
  int CenterRow(int cell_row) const;

 private:
  int width_;
  int height_;
  int step_;
  int num_cols_;
  int num_rows_;
};

// A plane that was chosen for the pixels of one segment in a cell.
struct ChosenPlane {
  int32_t segment = -1;  // -1 = none
  PlaneHypothesis plane;
};

// The views that vote on the planes of a view, out of `candidates` (ascending):
// all others of them if they are few; else kMaxVoters that are found by going
// from a view to its sources, to theirs, and so on. `sources`: source views of
// each view, which are candidates.
constexpr size_t kMaxVoters = 64;
std::vector<int> SelectVoters(int view_idx,
                              const std::vector<int>& candidates,
                              const std::vector<std::vector<int>>& sources);

// Lets other views vote on which of the planes of a view's segments are right.
// For each cell, a view agrees with a plane if it has the same depth where the
// plane is seen there, reliably or by one of the planes of its own segment; it
// has seen through the plane if it has something reliable farther away.
class PlaneVotes {
 public:
  // `planes`: of each segment, by label. Both must outlive this object.
  PlaneVotes(const PlaneView& view,
             const std::vector<std::vector<PlaneHypothesis>>& planes);

  // `warp`: from the view to `other`.
  void Count(const ViewWarp& warp,
             const PlaneView& other,
             const std::vector<std::vector<PlaneHypothesis>>& other_planes);

  // The plane of each cell with the most votes around it, in its own segment:
  // at least two views, on average, and no less than have seen through it.
  std::vector<ChosenPlane> Choose() const;

 private:
  struct Votes {
    float agree = 0;
    float through = 0;
  };

  // Of the segment in the middle of the cell; -1 = none.
  int32_t SegmentOfCell(int cell_col, int cell_row) const;

  // Votes for the planes of a cell's segment in the window around it.
  std::vector<Votes> SumAround(int cell_col, int cell_row, float* count) const;

  const PlaneView& view_;
  const std::vector<std::vector<PlaneHypothesis>>& planes_;
  const PlaneLattice lattice_;
  size_t max_planes_ = 0;     // of a segment
  std::vector<Votes> votes_;  // cells x max_planes_
};

}  // namespace structnerf
