#include "nerf/planes/plane_hypotheses.h"

#include "nerf/planes/plane_fit.h"
#include "nerf/planes/segment_anchors.h"
#include "nerf/planes/view_projection.h"
#include "nerf/util/median.h"
#include "nerf/util/random.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

namespace structnerf {
namespace {

// Blank pixels that are looked at per segment.
constexpr uint32_t kMaxBlankPixels = 100;

// Hypotheses of each kind that are drawn.
constexpr int kNumDraws = 300;

// Segments with a smaller share of the image without reliable pixels stay as
// they are.
constexpr double kMinBlankShare = 1.3e-3;

// By how much colours may differ more than at the present depth.
constexpr float kMaxColorExcess = 0.04f;

// What support and unlike colours weigh against a farther depth (logarithm).
constexpr float kSupportWeight = 3.0f;
constexpr float kColorWeight = 3.0f;

// Planes that are kept per segment, and how different they must be.
constexpr size_t kMaxPlanes = 4;
constexpr float kMinDifference = 0.03f;

// Anchors that see a plane edge-on, or lie too close together, do not fix it.
constexpr float kMinFacing = 1e-3f;
constexpr float kMinDeterminant = 5e-3f;

struct Candidate {
  PlaneHypothesis plane;

  float key = 0;  // larger is more likely
};

class HypothesisFinder {
 public:
  HypothesisFinder(const PlaneView& view,
                   const int border,
                   const Eigen::Vector3f& direction,
                   const int view_idx,
                   const std::vector<ViewWarp>& warps,
                   const std::vector<int>& sources,
                   const TrainingViews& views)
      : view_(view),
        segments_(CollectSegments(view, border, view_idx)),
        direction_(direction),
        view_idx_(view_idx),
        warps_(warps),
        sources_(sources),
        views_(views) {}

  std::vector<std::vector<PlaneHypothesis>> Find();

 private:
  std::vector<PlaneHypothesis> FindPlanes(int label);
  std::vector<PlaneHypothesis> DrawPlanes(const Segment& segment,
                                          Random* random) const;

  // Mean relative difference of two planes over blank pixels.
  float Difference(const Segment& segment,
                   const PlaneHypothesis& plane1,
                   const PlaneHypothesis& plane2) const;
  bool CompareColors(const Segment& segment, Candidate* candidate) const;
  float ColorDifference(int col, int row, float rho) const;

  const PlaneView& view_;
  std::vector<Segment> segments_;
  const Eigen::Vector3f direction_;
  const int view_idx_;
  const std::vector<ViewWarp>& warps_;
  const std::vector<int>& sources_;
  const TrainingViews& views_;
};

std::vector<std::vector<PlaneHypothesis>> HypothesisFinder::Find() {
  std::vector<std::vector<PlaneHypothesis>> planes(segments_.size());
  const size_t min_blank = static_cast<size_t>(
      kMinBlankShare * static_cast<double>(view_.width) * view_.height);
  for (size_t label = 0; label < segments_.size(); ++label) {
    if (segments_[label].blank_pixels.size() > min_blank &&
        segments_[label].anchors.size() > 2) {
      planes[label] = FindPlanes(static_cast<int>(label));
    }
  }
  return planes;
}

std::vector<PlaneHypothesis> HypothesisFinder::FindPlanes(const int label) {
  Segment& segment = segments_[label];
  Random random(view_idx_, label);
  // The first ones serve as a sample from now on.
  const uint32_t num_blank = static_cast<uint32_t>(segment.blank_pixels.size());
  for (uint32_t i = 0; i < num_blank; ++i) {
    std::swap(segment.blank_pixels[i],
              segment.blank_pixels[random.NextBelow(num_blank)]);
  }
  segment.blank_pixels.resize(std::min(num_blank, kMaxBlankPixels));

  std::vector<Candidate> possible;
  std::vector<PlaneHypothesis> looked_at;
  for (const PlaneHypothesis& plane : DrawPlanes(segment, &random)) {
    const bool is_new = std::none_of(
        looked_at.begin(), looked_at.end(), [&](const PlaneHypothesis& other) {
          return Difference(segment, plane, other) < kMinDifference;
        });
    if (is_new) {
      looked_at.push_back(plane);
      Candidate candidate;
      candidate.plane = plane;
      if (CompareColors(segment, &candidate)) {
        possible.push_back(candidate);
      }
    }
  }
  std::sort(
      possible.begin(),
      possible.end(),
      [](const Candidate& a, const Candidate& b) { return a.key > b.key; });
  std::vector<PlaneHypothesis> planes;
  for (size_t i = 0; i < std::min(possible.size(), kMaxPlanes); ++i) {
    planes.push_back(possible[i].plane);
  }
  return planes;
}

// Possible ones, the most supported first.
std::vector<PlaneHypothesis> HypothesisFinder::DrawPlanes(
    const Segment& segment, Random* random) const {
  const auto draw = [&]() -> const Anchor& {
    return segment.anchors[random->NextBelow(
        static_cast<uint32_t>(segment.anchors.size()))];
  };
  // Normals of upright planes are spanned by these.
  Eigen::Matrix<float, 3, 2> upright;
  upright.col(0) = direction_.unitOrthogonal();
  upright.col(1) = direction_.cross(upright.col(0));

  std::vector<PlaneHypothesis> planes;
  for (int i = 0; i < 2 * kNumDraws; ++i) {
    PlaneHypothesis plane;
    const Anchor& anchor = draw();
    if (i % 2 == 0) {
      const float facing = direction_.dot(anchor.ray);
      if (std::abs(facing) < kMinFacing) {
        continue;
      }
      plane.coefficients = anchor.rho / facing * direction_;
    } else {
      const Anchor& other = draw();
      Eigen::Matrix2f rays;
      rays.row(0) = anchor.ray.transpose() * upright;
      rays.row(1) = other.ray.transpose() * upright;
      if (std::abs(rays.determinant()) < kMinDeterminant) {
        continue;
      }
      plane.coefficients =
          upright * (rays.inverse() * Eigen::Vector2f(anchor.rho, other.rho));
    }
    if (FitToAnchors(view_, segment, &plane)) {
      planes.push_back(plane);
    }
  }
  std::stable_sort(planes.begin(),
                   planes.end(),
                   [](const PlaneHypothesis& a, const PlaneHypothesis& b) {
                     return a.support > b.support;
                   });
  return planes;
}

float HypothesisFinder::Difference(const Segment& segment,
                                   const PlaneHypothesis& plane1,
                                   const PlaneHypothesis& plane2) const {
  float sum = 0;
  for (const uint32_t pixel : segment.blank_pixels) {
    const Eigen::Vector3f ray =
        view_.Ray(static_cast<int>(pixel % view_.width),
                  static_cast<int>(pixel / view_.width));
    const float rho1 = plane1.InverseDepth(ray);
    const float rho2 = plane2.InverseDepth(ray);
    sum += std::abs(rho1 - rho2) / std::max(std::abs(rho2), 1e-6f);
  }
  return sum / static_cast<float>(segment.blank_pixels.size());
}

bool HypothesisFinder::CompareColors(const Segment& segment,
                                     Candidate* candidate) const {
  const size_t count = segment.blank_pixels.size();
  float excess = 0;
  std::vector<float> rhos;
  for (const uint32_t pixel : segment.blank_pixels) {
    const int col = static_cast<int>(pixel % view_.width);
    const int row = static_cast<int>(pixel / view_.width);
    const float rho = candidate->plane.InverseDepth(view_.Ray(col, row));
    if (!(rho > 0)) {
      return false;
    }
    rhos.push_back(rho);
    if (view_.rho[pixel] > 0) {
      excess += std::max(0.0f,
                         ColorDifference(col, row, rho) -
                             ColorDifference(col, row, view_.rho[pixel]));
    }
  }
  excess /= static_cast<float>(count);
  if (excess > kMaxColorExcess) {
    return false;
  }
  // The farther of two equally possible planes: what is nearer and belongs to
  // something in front would be explained by that.
  candidate->key = -std::log(static_cast<float>(Median(&rhos))) +
                   kSupportWeight * candidate->plane.support -
                   kColorWeight * excess;
  return true;
}

float HypothesisFinder::ColorDifference(const int col,
                                        const int row,
                                        const float rho) const {
  constexpr float kUnseen = 0.2f;
  const Eigen::Vector3f color = views_.Color(view_idx_, col, row);
  std::vector<float> differences;
  for (size_t i = 0; i < warps_.size(); ++i) {
    int source_col;
    int source_row;
    float depth_ratio;
    if (ProjectPixel(
            warps_[i], col, row, rho, &source_col, &source_row, &depth_ratio) &&
        !views_.IsMasked(sources_[i], source_col, source_row)) {
      differences.push_back(
          (views_.Color(sources_[i], source_col, source_row) - color)
              .cwiseAbs()
              .mean());
    }
  }
  if (differences.empty()) {
    return kUnseen;
  }
  // The worse half may be occluded.
  const size_t num_used = (differences.size() + 1) / 2;
  std::partial_sort(differences.begin(),
                    differences.begin() + static_cast<ptrdiff_t>(num_used),
                    differences.end());
  float sum = 0;
  for (size_t i = 0; i < num_used; ++i) {
    sum += differences[i];
  }
  return sum / static_cast<float>(num_used);
}

}  // namespace

std::vector<std::vector<PlaneHypothesis>> FindPlaneHypotheses(
    const PlaneView& view,
    const int border,
    const Eigen::Vector3f& direction,
    const int view_idx,
    const std::vector<ViewWarp>& warps,
    const std::vector<int>& sources,
    const TrainingViews& views) {
  return HypothesisFinder(
             view, border, direction, view_idx, warps, sources, views)
      .Find();
}

}  // namespace structnerf
