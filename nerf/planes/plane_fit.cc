#include "nerf/planes/plane_fit.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

namespace structnerf {
namespace {

// Relative difference in inverse depth up to which a pixel lies on a plane.
constexpr float kTolerance = 0.012f;

// Anchors on a plane: at least this many per pixel of the image's width, spread
// over this share of the segment's width or height.
constexpr float kMinAnchorsPerWidth = 0.028f;
constexpr float kMinExtent = 0.25f;

// Anchors inside the segment that may lie behind the plane, as a share of them,
// and those far from the border that may lie in front, per pixel there.
constexpr float kMaxShareBehind = 0.04f;
constexpr float kMaxDensityInFront = 0.03f;
constexpr float kMinInnerArea = 200.0f;

// Fits in turn, and how firmly each holds on to the plane as it was.
constexpr int kNumFits = 2;
constexpr float kFirmness = 2e-4f;

// How a segment's anchors lie to a plane.
struct AnchorCounts {
  float num_on = 0;
  float num_inside = 0;
  float num_behind = 0;    // of those inside
  float num_in_front = 0;  // of the inner ones

  // Normalised image coordinates of those on the plane.
  Eigen::Array2f lowest = Eigen::Array2f::Constant(1e30f);
  Eigen::Array2f highest = Eigen::Array2f::Constant(-1e30f);

  // Normal equations of a change of the coefficients for those on the plane;
  // relative errors, so that near and far anchors count alike.
  Eigen::Matrix3f normal_matrix = Eigen::Matrix3f::Zero();
  Eigen::Vector3f right_side = Eigen::Vector3f::Zero();
};

AnchorCounts CountAnchors(const Segment& segment,
                          const PlaneHypothesis& plane) {
  AnchorCounts counts;
  for (const Anchor& anchor : segment.anchors) {
    const float difference = 1 - plane.InverseDepth(anchor.ray) / anchor.rho;
    counts.num_inside += anchor.is_inside;
    if (std::abs(difference) < kTolerance) {
      ++counts.num_on;
      counts.lowest = counts.lowest.min(anchor.ray.head<2>().array());
      counts.highest = counts.highest.max(anchor.ray.head<2>().array());
      const Eigen::Vector3f x = anchor.ray / anchor.rho;
      counts.normal_matrix += x * x.transpose();
      counts.right_side += difference * x;
    } else if (difference < -2 * kTolerance) {
      counts.num_behind += anchor.is_inside;
    } else if (difference > 2 * kTolerance) {
      counts.num_in_front += anchor.is_inner;
    }
  }
  return counts;
}

bool IsPossible(const PlaneView& view,
                const Segment& segment,
                const AnchorCounts& counts) {
  // From the anchors that were kept to all.
  const float scale = static_cast<float>(segment.num_anchors) /
                      static_cast<float>(segment.anchors.size());
  const float width = static_cast<float>(segment.max_col - segment.min_col);
  const float height = static_cast<float>(segment.max_row - segment.min_row);
  const Eigen::Array2f extent =
      (counts.highest - counts.lowest) *
      Eigen::Array2f(static_cast<float>(view.camera.fx) / (width + 1),
                     static_cast<float>(view.camera.fy) / (height + 1));
  return scale * counts.num_on >= kMinAnchorsPerWidth * view.width &&
         extent.maxCoeff() > kMinExtent &&
         counts.num_behind <= kMaxShareBehind * counts.num_inside &&
         scale * counts.num_in_front <=
             kMaxDensityInFront *
                 std::max(kMinInnerArea, static_cast<float>(segment.num_inner));
}

}  // namespace

bool FitToAnchors(const PlaneView& view,
                  const Segment& segment,
                  PlaneHypothesis* plane) {
  AnchorCounts counts = CountAnchors(segment, *plane);
  for (int i = 0; i < kNumFits && IsPossible(view, segment, counts); ++i) {
    counts.normal_matrix +=
        kFirmness * counts.normal_matrix.trace() * Eigen::Matrix3f::Identity();
    plane->coefficients += counts.normal_matrix.ldlt().solve(counts.right_side);
    counts = CountAnchors(segment, *plane);
  }
  plane->support = counts.num_on / static_cast<float>(segment.anchors.size());
  return IsPossible(view, segment, counts) && plane->coefficients.allFinite();
}

}  // namespace structnerf
