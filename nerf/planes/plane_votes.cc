#include "nerf/planes/plane_votes.h"

#include "nerf/planes/view_projection.h"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace structnerf {
namespace {

// Views agree on a plane within this relative difference; a reliable pixel this
// much behind it has been seen through it.
constexpr float kAgreeTolerance = 0.02f;
constexpr float kThroughTolerance = 0.03f;

// Lattice cells per image width on which planes are chosen, and half the side
// of the window over which votes are summed, in cells.
constexpr int kCellsPerWidth = 160;
constexpr int kVoteRadius = 2;

// Other views that must agree, on average over the window.
constexpr float kMinVotes = 2.0f;

// Planes with this share of the most votes are equally likely by votes alone.
constexpr float kEqualVotes = 0.9f;

bool HasPlaneAt(const std::vector<PlaneHypothesis>& planes,
                const Eigen::Vector3f& ray,
                const float rho,
                const float tolerance) {
  return std::any_of(
      planes.begin(), planes.end(), [&](const PlaneHypothesis& plane) {
        return std::abs(plane.InverseDepth(ray) - rho) < tolerance;
      });
}

}  // namespace

PlaneLattice::PlaneLattice(const int width, const int height)
    : width_(width),
      height_(height),
      step_(std::max(1, width / kCellsPerWidth)),
      num_cols_((width + step_ - 1) / step_),
      num_rows_((height + step_ - 1) / step_) {}

int PlaneLattice::CenterCol(const int cell_col) const {
  return std::min(cell_col * step_ + step_ / 2, width_ - 1);
}

int PlaneLattice::CenterRow(const int cell_row) const {
  return std::min(cell_row * step_ + step_ / 2, height_ - 1);
}

std::vector<int> SelectVoters(const int view_idx,
                              const std::vector<int>& candidates,
                              const std::vector<std::vector<int>>& sources) {
  std::vector<int> voters;
  if (candidates.size() <= kMaxVoters + 1) {
    std::remove_copy(candidates.begin(),
                     candidates.end(),
                     std::back_inserter(voters),
                     view_idx);
    return voters;
  }
  std::vector<uint8_t> is_known(sources.size(), 0);
  is_known[view_idx] = 1;
  const auto add_sources = [&](const int of_view_idx) {
    for (const int source : sources[of_view_idx]) {
      if (voters.size() < kMaxVoters && !is_known[source]) {
        is_known[source] = 1;
        voters.push_back(source);
      }
    }
  };
  add_sources(view_idx);
  for (size_t i = 0; i < voters.size(); ++i) {
    add_sources(voters[i]);
  }
  return voters;
}

PlaneVotes::PlaneVotes(const PlaneView& view,
                       const std::vector<std::vector<PlaneHypothesis>>& planes)
    : view_(view), planes_(planes), lattice_(view.width, view.height) {
  for (const auto& segment_planes : planes) {
    max_planes_ = std::max(max_planes_, segment_planes.size());
  }
  votes_.resize(lattice_.NumCells() * max_planes_);
}

int32_t PlaneVotes::SegmentOfCell(const int cell_col,
                                  const int cell_row) const {
  return view_.segments[view_.Index(lattice_.CenterCol(cell_col),
                                    lattice_.CenterRow(cell_row))];
}

void PlaneVotes::Count(
    const ViewWarp& warp,
    const PlaneView& other,
    const std::vector<std::vector<PlaneHypothesis>>& other_planes) {
  for (int cell_row = 0; cell_row < lattice_.NumRows(); ++cell_row) {
    for (int cell_col = 0; cell_col < lattice_.NumCols(); ++cell_col) {
      const int32_t segment = SegmentOfCell(cell_col, cell_row);
      if (segment < 0 || planes_[segment].empty()) {
        continue;
      }
      const int col = lattice_.CenterCol(cell_col);
      const int row = lattice_.CenterRow(cell_row);
      const Eigen::Vector3f ray = view_.Ray(col, row);
      for (size_t k = 0; k < planes_[segment].size(); ++k) {
        const float rho = planes_[segment][k].InverseDepth(ray);
        int other_col;
        int other_row;
        float ratio;
        if (!(rho > 0) ||
            !ProjectPixel(
                warp, col, row, rho, &other_col, &other_row, &ratio)) {
          continue;
        }
        Votes& votes =
            votes_[lattice_.Index(cell_col, cell_row) * max_planes_ + k];
        const float expected = rho / ratio;
        const float tolerance = kAgreeTolerance * expected;
        const size_t index = other.Index(other_col, other_row);
        if (other.is_reliable[index]) {
          votes.agree += std::abs(other.rho[index] - expected) < tolerance;
          votes.through +=
              other.rho[index] < expected * (1 - kThroughTolerance);
        } else if (other.segments[index] >= 0) {
          votes.agree += HasPlaneAt(other_planes[other.segments[index]],
                                    other.Ray(other_col, other_row),
                                    expected,
                                    tolerance);
        }
      }
    }
  }
}

std::vector<PlaneVotes::Votes> PlaneVotes::SumAround(const int cell_col,
                                                     const int cell_row,
                                                     float* count) const {
  const int32_t segment = SegmentOfCell(cell_col, cell_row);
  std::vector<Votes> sums(planes_[segment].size());
  *count = 0;
  for (int row = std::max(0, cell_row - kVoteRadius);
       row <= std::min(lattice_.NumRows() - 1, cell_row + kVoteRadius);
       ++row) {
    for (int col = std::max(0, cell_col - kVoteRadius);
         col <= std::min(lattice_.NumCols() - 1, cell_col + kVoteRadius);
         ++col) {
      if (SegmentOfCell(col, row) != segment) {
        continue;
      }
      ++*count;
      for (size_t k = 0; k < sums.size(); ++k) {
        const Votes& votes = votes_[lattice_.Index(col, row) * max_planes_ + k];
        sums[k].agree += votes.agree;
        sums[k].through += votes.through;
      }
    }
  }
  return sums;
}

std::vector<ChosenPlane> PlaneVotes::Choose() const {
  std::vector<ChosenPlane> chosen(lattice_.NumCells());
  for (int row = 0; row < lattice_.NumRows(); ++row) {
    for (int col = 0; col < lattice_.NumCols(); ++col) {
      const int32_t segment = SegmentOfCell(col, row);
      if (segment < 0 || planes_[segment].empty()) {
        continue;
      }
      float count;
      const std::vector<Votes> sums = SumAround(col, row, &count);
      float most = 0;
      for (const Votes& sum : sums) {
        if (sum.agree >= sum.through) {
          most = std::max(most, sum.agree);
        }
      }
      if (most < kMinVotes * count) {
        continue;
      }
      // Planes close to each other get much the same votes, and the one that
      // more reliable pixels lie on is right.
      const float enough = std::max(kMinVotes * count, kEqualVotes * most);
      ChosenPlane& best = chosen[lattice_.Index(col, row)];
      for (size_t k = 0; k < sums.size(); ++k) {
        const PlaneHypothesis& plane = planes_[segment][k];
        if (sums[k].agree >= sums[k].through && sums[k].agree >= enough &&
            plane.support > best.plane.support) {
          best = {segment, plane};
        }
      }
    }
  }
  return chosen;
}

}  // namespace structnerf
