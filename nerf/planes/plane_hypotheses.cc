#include "nerf/planes/plane_hypotheses.h"

#include "nerf/planes/view_projection.h"
#include "nerf/util/random.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

namespace structnerf {
namespace {

// Relative difference in inverse depth up to which a pixel lies on a plane.
constexpr float kTolerance = 0.012f;

// Anchors and blank pixels that are looked at per segment.
constexpr size_t kMaxAnchors = 800;
constexpr uint32_t kMaxBlankPixels = 100;

// Hypotheses of each kind that are drawn.
constexpr int kNumDraws = 300;

// Segments with a smaller share of the image without reliable pixels stay as
// they are.
constexpr double kMinBlankShare = 1.3e-3;

// Anchors on a plane: at least this many per pixel of the image's width, spread
// over this share of the segment's width or height.
constexpr float kMinAnchorsPerWidth = 0.028f;
constexpr float kMinExtent = 0.25f;

// Anchors inside the segment that may lie behind the plane, as a share of them,
// and those far from the border that may lie in front, per pixel there.
constexpr float kMaxShareBehind = 0.04f;
constexpr float kMaxDensityInFront = 0.03f;
constexpr float kMinInnerArea = 200.0f;

// By how much colours may differ more than at the present depth.
constexpr float kMaxColorExcess = 0.04f;

// What support and unlike colours weigh against a farther depth (logarithm).
constexpr float kSupportWeight = 3.0f;
constexpr float kColorWeight = 3.0f;

// Refinements of a drawn plane, and how firmly each holds on to what it was:
// anchors along one line leave the plane as it was drawn, those spread over an
// area tilt it as they need.
constexpr int kNumFits = 2;
constexpr float kFirmness = 2e-4f;

// Planes that are kept per segment, and how different they must be.
constexpr size_t kMaxPlanes = 4;
constexpr float kMinDifference = 0.03f;

// Anchors that see a plane edge-on, or lie too close together, do not fix it.
constexpr float kMinFacing = 1e-3f;
constexpr float kMinDeterminant = 5e-3f;

// A reliable pixel in or around a segment.
struct Anchor {
  Eigen::Vector3f ray;
  float rho = 0;
  bool is_inside = false;
  bool is_inner = false;  // farther from the border than matches may be off
};

struct Segment {
  int min_col = 1 << 30;
  int max_col = -1;
  int min_row = 1 << 30;
  int max_row = -1;
  size_t num_inner = 0;    // pixels
  size_t num_anchors = 0;  // all that were seen
  std::vector<Anchor> anchors;
  std::vector<uint32_t> blank_pixels;  // without reliable depth
};

struct Candidate {
  PlaneHypothesis plane;

  float key = 0;  // larger is more likely
};

class HypothesisFinder {
 public:
  HypothesisFinder(const PlaneView& view,
                   const std::vector<int32_t>& segments,
                   const int border,
                   const Eigen::Vector3f& direction,
                   const int view_idx,
                   const std::vector<ViewWarp>& warps,
                   const std::vector<int>& sources,
                   const TrainingViews& views)
      : view_(view),
        labels_(segments),
        border_(border),
        direction_(direction),
        view_idx_(view_idx),
        warps_(warps),
        sources_(sources),
        views_(views) {}

  std::vector<std::vector<PlaneHypothesis>> Find();

 private:
  void CollectSegments();
  std::vector<PlaneHypothesis> FindPlanes(int label);
  std::vector<Candidate> DrawCandidates(const Segment& segment,
                                        Random* random) const;

  // Mean relative difference of two planes over blank pixels.
  float Difference(const Segment& segment,
                   const PlaneHypothesis& plane1,
                   const PlaneHypothesis& plane2) const;
  bool FitAndScore(const Segment& segment, Candidate* candidate) const;
  bool CompareColors(const Segment& segment, Candidate* candidate) const;
  float ColorDifference(int col, int row, float rho) const;

  const PlaneView& view_;
  const std::vector<int32_t>& labels_;
  const int border_;
  const Eigen::Vector3f direction_;
  const int view_idx_;
  const std::vector<ViewWarp>& warps_;
  const std::vector<int>& sources_;
  const TrainingViews& views_;
  std::vector<Segment> segments_;
};

std::vector<std::vector<PlaneHypothesis>> HypothesisFinder::Find() {
  CollectSegments();
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

void HypothesisFinder::CollectSegments() {
  const auto label_at = [&](const int col, const int row) {
    const bool is_in_image =
        col >= 0 && row >= 0 && col < view_.width && row < view_.height;
    return is_in_image ? labels_[view_.Index(col, row)] : -1;
  };
  const auto max_label = std::max_element(labels_.begin(), labels_.end());
  segments_.resize(max_label == labels_.end() ? 0 : *max_label + 1);
  Random random(view_idx_);
  std::vector<int32_t> labels_around;
  for (int row = 0; row < view_.height; ++row) {
    for (int col = 0; col < view_.width; ++col) {
      const size_t index = view_.Index(col, row);
      const int32_t label = labels_[index];
      const bool is_reliable = view_.is_reliable[index] != 0;
      if (!is_reliable && label < 0) {
        continue;
      }
      labels_around.clear();
      bool is_inner = true;
      for (int dy = -border_; dy <= border_; dy += border_ / 2) {
        for (int dx = -border_; dx <= border_; dx += border_ / 2) {
          const int32_t other = label_at(col + dx, row + dy);
          is_inner = is_inner && other == label;
          if (other >= 0 &&
              std::count(labels_around.begin(), labels_around.end(), other) ==
                  0) {
            labels_around.push_back(other);
          }
        }
      }
      if (label >= 0) {
        Segment& segment = segments_[label];
        segment.min_col = std::min(segment.min_col, col);
        segment.max_col = std::max(segment.max_col, col);
        segment.min_row = std::min(segment.min_row, row);
        segment.max_row = std::max(segment.max_row, row);
        segment.num_inner += is_inner;
        if (!is_reliable) {
          segment.blank_pixels.push_back(static_cast<uint32_t>(index));
        }
      }
      if (!is_reliable) {
        continue;
      }
      for (const int32_t other : labels_around) {
        Segment& segment = segments_[other];
        const Anchor anchor{view_.Ray(col, row),
                            view_.rho[index],
                            other == label,
                            other == label && is_inner};
        // A random choice of all.
        if (segment.anchors.size() < kMaxAnchors) {
          segment.anchors.push_back(anchor);
        } else {
          const uint32_t place =
              random.NextBelow(static_cast<uint32_t>(segment.num_anchors + 1));
          if (place < kMaxAnchors) {
            segment.anchors[place] = anchor;
          }
        }
        ++segment.num_anchors;
      }
    }
  }
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
  for (Candidate& candidate : DrawCandidates(segment, &random)) {
    const bool is_new = std::none_of(
        looked_at.begin(), looked_at.end(), [&](const PlaneHypothesis& other) {
          return Difference(segment, candidate.plane, other) < kMinDifference;
        });
    if (is_new) {
      looked_at.push_back(candidate.plane);
      if (CompareColors(segment, &candidate)) {
        possible.push_back(std::move(candidate));
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
std::vector<Candidate> HypothesisFinder::DrawCandidates(const Segment& segment,
                                                        Random* random) const {
  const auto draw = [&]() -> const Anchor& {
    return segment.anchors[random->NextBelow(
        static_cast<uint32_t>(segment.anchors.size()))];
  };
  // Normals of upright planes are spanned by these.
  Eigen::Matrix<float, 3, 2> upright;
  upright.col(0) = direction_.unitOrthogonal();
  upright.col(1) = direction_.cross(upright.col(0));

  std::vector<Candidate> candidates;
  for (int i = 0; i < 2 * kNumDraws; ++i) {
    Candidate candidate;
    const Anchor& anchor = draw();
    if (i % 2 == 0) {
      const float facing = direction_.dot(anchor.ray);
      if (std::abs(facing) < kMinFacing) {
        continue;
      }
      candidate.plane.coefficients = anchor.rho / facing * direction_;
    } else {
      const Anchor& other = draw();
      Eigen::Matrix2f rays;
      rays.row(0) = anchor.ray.transpose() * upright;
      rays.row(1) = other.ray.transpose() * upright;
      if (std::abs(rays.determinant()) < kMinDeterminant) {
        continue;
      }
      candidate.plane.coefficients =
          upright * (rays.inverse() * Eigen::Vector2f(anchor.rho, other.rho));
    }
    if (FitAndScore(segment, &candidate)) {
      candidates.push_back(std::move(candidate));
    }
  }
  std::stable_sort(candidates.begin(),
                   candidates.end(),
                   [](const Candidate& a, const Candidate& b) {
                     return a.plane.support > b.plane.support;
                   });
  return candidates;
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

bool HypothesisFinder::FitAndScore(const Segment& segment,
                                   Candidate* candidate) const {
  const float scale = static_cast<float>(segment.num_anchors) /
                      static_cast<float>(segment.anchors.size());
  PlaneHypothesis& plane = candidate->plane;
  // As drawn, then fitted to what lies on it.
  for (int fit = 0; fit <= kNumFits; ++fit) {
    Eigen::Matrix3f normal_matrix = Eigen::Matrix3f::Zero();
    Eigen::Vector3f residual = Eigen::Vector3f::Zero();
    float num_on = 0;
    float num_inside = 0;
    float num_behind = 0;
    float num_in_front = 0;
    Eigen::Array2f lowest(1e30f, 1e30f);
    Eigen::Array2f highest(-1e30f, -1e30f);
    for (const Anchor& anchor : segment.anchors) {
      const float difference = 1 - plane.InverseDepth(anchor.ray) / anchor.rho;
      num_inside += anchor.is_inside;
      if (std::abs(difference) < kTolerance) {
        ++num_on;
        lowest = lowest.min(anchor.ray.head<2>().array());
        highest = highest.max(anchor.ray.head<2>().array());
        // Relative errors, so that near and far anchors count alike.
        const Eigen::Vector3f x = anchor.ray / anchor.rho;
        normal_matrix += x * x.transpose();
        residual += difference * x;
      } else if (difference < -2 * kTolerance) {
        num_behind += anchor.is_inside;
      } else if (difference > 2 * kTolerance) {
        num_in_front += anchor.is_inner;
      }
    }
    const float width = static_cast<float>(segment.max_col - segment.min_col);
    const float height = static_cast<float>(segment.max_row - segment.min_row);
    const Eigen::Array2f extent =
        (highest - lowest) *
        Eigen::Array2f(static_cast<float>(view_.camera.fx) / (width + 1),
                       static_cast<float>(view_.camera.fy) / (height + 1));
    if (scale * num_on < kMinAnchorsPerWidth * view_.width ||
        !(extent.maxCoeff() > kMinExtent) ||
        num_behind > kMaxShareBehind * num_inside ||
        scale * num_in_front >
            kMaxDensityInFront *
                std::max(kMinInnerArea,
                         static_cast<float>(segment.num_inner))) {
      return false;
    }
    plane.support = num_on / segment.anchors.size();
    if (fit < kNumFits) {
      // What the anchors leave open stays as it was drawn: level or upright.
      normal_matrix +=
          kFirmness * normal_matrix.trace() * Eigen::Matrix3f::Identity();
      plane.coefficients += normal_matrix.ldlt().solve(residual);
    }
  }
  return plane.coefficients.allFinite();
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
    excess += std::max(0.0f,
                       ColorDifference(col, row, rho) -
                           ColorDifference(col, row, view_.rho[pixel]));
  }
  excess /= static_cast<float>(count);
  if (excess > kMaxColorExcess) {
    return false;
  }
  std::nth_element(rhos.begin(), rhos.begin() + count / 2, rhos.end());
  // The farther of two equally possible planes: what is nearer and belongs to
  // something in front would be explained by that.
  candidate->key = -std::log(rhos[count / 2]) +
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
    const std::vector<int32_t>& segments,
    const int border,
    const Eigen::Vector3f& direction,
    const int view_idx,
    const std::vector<ViewWarp>& warps,
    const std::vector<int>& sources,
    const TrainingViews& views) {
  return HypothesisFinder(
             view, segments, border, direction, view_idx, warps, sources, views)
      .Find();
}

}  // namespace structnerf
