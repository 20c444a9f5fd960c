#include "nerf/extract/normal_estimation.h"

#include "nerf/extract/map_resolution.h"
#include "nerf/watched_loop.h"

#include <algorithm>
#include <limits>
#include <vector>

// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nerf/extract/normal_estimation.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// clang-format on

namespace structnerf {
#ifndef NERF_EXTRACT_NORMAL_ESTIMATION_ONCE_
#define NERF_EXTRACT_NORMAL_ESTIMATION_ONCE_

// Half the side of the window in taps, and the distance of the taps in maps of
// the reference size.
constexpr int kWindowTaps = 3;
constexpr int kTapStep = 2;

// Neighbours count by 1 / (1 + (relative difference in depth / this)^4).
constexpr float kDepthFalloff = 0.03f;

// A trace of regularisation, in taps squared, makes an isolated pixel face the
// camera.
constexpr float kRegularization = 2.5e-4f;

constexpr size_t kMaxLanes = 16;

// Inverse depth, 0 where there is none, with a margin of such on either side
// that windows and vectors at the border may read.
struct InverseDepth {
  InverseDepth(const PinholeCamera& camera, const DenseMaps& maps)
      : step(kTapStep * WholePixelsPerReferencePixel(camera)),
        margin(kWindowTaps * step),
        stride(maps.width + 2 * margin + kMaxLanes),
        values(stride * maps.height, 0.0f) {
    for (int row = 0; row < maps.height; ++row) {
      const float* const depth =
          maps.depth.data() + static_cast<size_t>(row) * maps.width;
      float* const inverse = values.data() + row * stride + margin;
      for (int col = 0; col < maps.width; ++col) {
        inverse[col] = depth[col] > 0 ? 1.0f / depth[col] : 0.0f;
      }
    }
  }

  const float* Row(const int row) const {
    return values.data() + row * stride + margin;
  }

  int step;  // pixels between taps
  size_t margin;
  size_t stride;
  std::vector<float> values;
};

#endif  // NERF_EXTRACT_NORMAL_ESTIMATION_ONCE_
}  // namespace structnerf

HWY_BEFORE_NAMESPACE();
namespace structnerf {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<float, kMaxLanes>;
using V = hn::VFromD<D>;

// Sums over the taps of a window, weighted by w: of 1, x, y and their products,
// and of those with r, the relative difference in inverse depth to the centre.
// In units of the centre's inverse depth and of taps, so that single precision
// is enough at any scale.
struct Moments {
  explicit Moments(const D d)
      : w(hn::Zero(d)), x(w), y(w), xx(w), xy(w), yy(w), r(w), xr(w), yr(w) {}

  V w, x, y, xx, xy, yy, r, xr, yr;
};

// `center`: inverse depth of the first of a vector of pixels.
HWY_INLINE Moments SumWindow(const D d,
                             const InverseDepth& inverse_depth,
                             const int min_dy,
                             const int max_dy,
                             const float* HWY_RESTRICT center) {
  const V one = hn::Set(d, 1.0f);
  const V zero = hn::Zero(d);
  const V by_falloff = hn::Set(d, 1.0f / kDepthFalloff);
  const V depth = hn::Div(one, hn::LoadU(d, center));
  const ptrdiff_t row_step =
      inverse_depth.step * static_cast<ptrdiff_t>(inverse_depth.stride);
  Moments sum(d);
  for (int dy = min_dy; dy <= max_dy; ++dy) {
    V w = zero, x = zero, xx = zero, r = zero, xr = zero;
    for (int dx = -kWindowTaps; dx <= kWindowTaps; ++dx) {
      const V other =
          hn::LoadU(d, center + dy * row_step + dx * inverse_depth.step);
      const V difference = hn::MulSub(depth, other, one);
      const V in_falloffs = hn::Mul(difference, by_falloff);
      const V squared = hn::Mul(in_falloffs, in_falloffs);
      const V weight = hn::IfThenElseZero(
          hn::Gt(other, zero), hn::Div(one, hn::MulAdd(squared, squared, one)));
      const V col = hn::Set(d, static_cast<float>(dx));
      const V weighted_col = hn::Mul(weight, col);
      w = hn::Add(w, weight);
      x = hn::Add(x, weighted_col);
      xx = hn::MulAdd(weighted_col, col, xx);
      r = hn::MulAdd(weight, difference, r);
      xr = hn::MulAdd(weighted_col, difference, xr);
    }
    const V row = hn::Set(d, static_cast<float>(dy));
    const V weighted_row = hn::Mul(w, row);
    sum.w = hn::Add(sum.w, w);
    sum.x = hn::Add(sum.x, x);
    sum.y = hn::Add(sum.y, weighted_row);
    sum.xx = hn::Add(sum.xx, xx);
    sum.xy = hn::MulAdd(x, row, sum.xy);
    sum.yy = hn::MulAdd(weighted_row, row, sum.yy);
    sum.r = hn::Add(sum.r, r);
    sum.xr = hn::Add(sum.xr, xr);
    sum.yr = hn::MulAdd(r, row, sum.yr);
  }
  return sum;
}

// The fit of r = by_x x + by_y y + constant to the taps.
struct Fit {
  V by_x, by_y, constant;
};

HWY_INLINE Fit Solve(const D d, const Moments& sum) {
  // Around the mean of the taps. The centre has weight 1, so w is not less.
  const V by_w = hn::Div(hn::Set(d, 1.0f), sum.w);
  const V mean_x = hn::Mul(sum.x, by_w);
  const V mean_y = hn::Mul(sum.y, by_w);
  const V regularization = hn::Set(d, kRegularization);
  // Rounding may not make a variance negative.
  const auto variance = [&](const V squares, const V mean, const V first) {
    return hn::Add(hn::Max(hn::NegMulAdd(mean, first, squares), hn::Zero(d)),
                   regularization);
  };
  const V xx = variance(sum.xx, mean_x, sum.x);
  const V yy = variance(sum.yy, mean_y, sum.y);
  const V xy = hn::NegMulAdd(mean_x, sum.y, sum.xy);
  const V xr = hn::NegMulAdd(mean_x, sum.r, sum.xr);
  const V yr = hn::NegMulAdd(mean_y, sum.r, sum.yr);
  const V ratio = hn::Div(xy, xx);
  const V remaining = hn::Max(hn::NegMulAdd(ratio, xy, yy), regularization);
  Fit fit;
  fit.by_y = hn::Div(hn::NegMulAdd(ratio, xr, yr), remaining);
  fit.by_x = hn::Div(hn::NegMulAdd(xy, fit.by_y, xr), xx);
  fit.constant = hn::NegMulAdd(
      fit.by_x, mean_x, hn::NegMulAdd(fit.by_y, mean_y, hn::Mul(sum.r, by_w)));
  return fit;
}

void EstimateRow(const PinholeCamera& camera,
                 const InverseDepth& inverse_depth,
                 const int row,
                 DenseMaps* maps) {
  const D d;
  const size_t width = maps->width;
  const size_t num_pixels = width * maps->height;
  const int min_dy = -std::min(kWindowTaps, row / inverse_depth.step);
  const int max_dy =
      std::min(kWindowTaps, (maps->height - 1 - row) / inverse_depth.step);
  const V taps_per_x =
      hn::Set(d, static_cast<float>(camera.fx / inverse_depth.step));
  const V taps_per_y =
      hn::Set(d, static_cast<float>(camera.fy / inverse_depth.step));
  const V zero = hn::Zero(d);
  const V one = hn::Set(d, 1.0f);
  const V ray_y = hn::Set(d, static_cast<float>((row - camera.cy) / camera.fy));
  const V by_fx = hn::Set(d, static_cast<float>(1.0 / camera.fx));
  const V largest = hn::Set(d, std::numeric_limits<float>::max());
  const float* const inverse_row = inverse_depth.Row(row);
  for (size_t col = 0; col < width; col += hn::Lanes(d)) {
    const Fit fit = Solve(
        d, SumWindow(d, inverse_depth, min_dy, max_dy, inverse_row + col));
    const V ray_x =
        hn::Mul(hn::Add(hn::Iota(d, 0.0f),
                        hn::Set(d, static_cast<float>(col - camera.cx))),
                by_fx);
    const V by_x = hn::Mul(fit.by_x, taps_per_x);
    const V by_y = hn::Mul(fit.by_y, taps_per_y);
    // On the optical axis.
    const V at_origin = hn::NegMulAdd(
        by_x, ray_x, hn::NegMulAdd(by_y, ray_y, hn::Add(one, fit.constant)));
    const V square = hn::MulAdd(
        by_x, by_x, hn::MulAdd(by_y, by_y, hn::Mul(at_origin, at_origin)));
    const V towards_ray =
        hn::MulAdd(by_x, ray_x, hn::MulAdd(by_y, ray_y, at_origin));
    // Also false for NaN.
    const auto is_usable =
        hn::And(hn::And(hn::Gt(square, zero), hn::Le(square, largest)),
                hn::Gt(towards_ray, zero));
    const V x = hn::IfThenElse(is_usable, by_x, ray_x);
    const V y = hn::IfThenElse(is_usable, by_y, ray_y);
    const V z = hn::IfThenElse(is_usable, at_origin, one);
    const V norm = hn::Sqrt(hn::MulAdd(x, x, hn::MulAdd(y, y, hn::Mul(z, z))));
    const V scale =
        hn::IfThenElseZero(hn::Gt(hn::LoadU(d, inverse_row + col), zero),
                           hn::Neg(hn::Div(one, norm)));
    HWY_ALIGN float normal[3][kMaxLanes];
    hn::Store(hn::Mul(x, scale), d, normal[0]);
    hn::Store(hn::Mul(y, scale), d, normal[1]);
    hn::Store(hn::Mul(z, scale), d, normal[2]);
    const size_t count = std::min(hn::Lanes(d), width - col);
    for (size_t axis = 0; axis < 3; ++axis) {
      std::copy_n(normal[axis],
                  count,
                  maps->normal.data() + axis * num_pixels + row * width + col);
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace structnerf
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace structnerf {

HWY_EXPORT(EstimateRow);

namespace {

void Estimate(const PinholeCamera& camera,
              const InverseDepth& inverse_depth,
              const int row,
              DenseMaps* maps) {
  HWY_DYNAMIC_DISPATCH(EstimateRow)(camera, inverse_depth, row, maps);
}

void ResizeNormals(DenseMaps* maps) {
  maps->normal.resize(3 * static_cast<size_t>(maps->width) * maps->height);
}

}  // namespace

void EstimateNormals(const PinholeCamera& camera, DenseMaps* maps) {
  ResizeNormals(maps);
  const InverseDepth inverse_depth(camera, *maps);
  for (int row = 0; row < maps->height; ++row) {
    Estimate(camera, inverse_depth, row, maps);
  }
}

void EstimateNormals(const PinholeCamera& camera,
                     ThreadPool* pool,
                     Progress* progress,
                     DenseMaps* maps) {
  ResizeNormals(maps);
  const InverseDepth inverse_depth(camera, *maps);
  WatchedParallelFor(static_cast<size_t>(maps->height),
                     pool,
                     progress,
                     [&](const size_t row, int) {
                       Estimate(
                           camera, inverse_depth, static_cast<int>(row), maps);
                     });
}

}  // namespace structnerf
#endif  // HWY_ONCE
