// Cost of matching the patch around a pixel with its sources, in vectors of
// pixels. Included once per instruction set, see Highway's documentation of
// foreach_target.h.

#if defined(NERF_STEREO_WINDOW_COST_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef NERF_STEREO_WINDOW_COST_INL_H_
#undef NERF_STEREO_WINDOW_COST_INL_H_
#else
#define NERF_STEREO_WINDOW_COST_INL_H_
#endif

#include "nerf/losses/view_warp-inl.h"
#include "nerf/options.h"

#include <algorithm>

#include <hwy/contrib/math/math-inl.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace structnerf {
namespace HWY_NAMESPACE {

using DU = hn::RebindToUnsigned<D>;

constexpr int kMaxWindowTaps = 121;

// Fall-off of a tap's weight with its difference in grey value to the centre,
// and with its distance in units of the window's radius.
constexpr float kColorFalloff = 0.12f;
constexpr float kSpaceFalloff = 1.0f;

// Variance in grey value (of [0, 1]) below which a patch has no texture: noise
// of about one grey level.
constexpr float kNoiseVariance = 1.5e-5f;

constexpr float kWorstCost = 2.0f;

// Most taps along a side of the window.
constexpr int kMaxWindowSide = 11;
static_assert(kMaxWindowSide * kMaxWindowSide == kMaxWindowTaps);

// Distance in pixels that a window keeps from the border of a source, so that
// taps whose place is rounded stay inside.
constexpr float kBorder = 0.01f;

// Taps of the view itself, row by row: weights sum to one, values have mean
// zero.
struct Window {
  int num_taps = 0;
  int side = 0;                  // taps per row and column
  float offset[kMaxWindowSide];  // of a row or column from the centre
  V weight[kMaxWindowTaps];
  V reference[kMaxWindowTaps];
  V variance;
};

struct Planes {
  V rho;
  V rho_x;
  V rho_y;
};

// Around `num_pixels` pixels of one row. Taps outside of the image and masked
// ones have no weight; around a masked pixel, none has.
HWY_INLINE void ReadWindow(const StereoOptions& options,
                           const uint16_t* image,
                           const int width,
                           const int height,
                           const int num_pixels,
                           const int* cols,
                           const int row,
                           Window* window) {
  const D d;
  const int radius = options.window_radius;
  const int step = options.window_step;
  HWY_ALIGN float center[16] = {};
  bool is_masked[16] = {};
  for (int i = 0; i < num_pixels; ++i) {
    const uint16_t gray = image[static_cast<size_t>(row) * width + cols[i]];
    center[i] = kInverseMaxGray * gray;
    is_masked[i] = gray == TrainingViews::kMaskedGray;
  }
  const V center_value = hn::Load(d, center);
  window->num_taps = 0;
  window->side = 0;
  for (int offset = -radius; offset <= radius; offset += step) {
    window->offset[window->side++] = static_cast<float>(offset);
  }
  V sum_weights = hn::Zero(d);
  V sum = hn::Zero(d);
  for (int dy = -radius; dy <= radius; dy += step) {
    for (int dx = -radius; dx <= radius; dx += step) {
      HWY_ALIGN float values[16] = {};
      HWY_ALIGN float inside[16] = {};
      const int y = row + dy;
      if (y >= 0 && y < height) {
        for (int i = 0; i < num_pixels; ++i) {
          const int x = cols[i] + dx;
          if (x >= 0 && x < width) {
            const uint16_t gray = image[static_cast<size_t>(y) * width + x];
            values[i] = kInverseMaxGray * gray;
            inside[i] = !is_masked[i] && gray != TrainingViews::kMaskedGray;
          }
        }
      }
      const int tap = window->num_taps++;
      // Relative to the centre, blank patches are exactly zero.
      const V value = hn::Sub(hn::Load(d, values), center_value);
      const float distance2 =
          static_cast<float>(dx * dx + dy * dy) / (radius * radius);
      const V exponent =
          hn::Add(hn::Mul(hn::Abs(value), hn::Set(d, -1.0f / kColorFalloff)),
                  hn::Set(d, -distance2 / (2 * kSpaceFalloff * kSpaceFalloff)));
      const V weight = hn::Mul(hn::Exp(d, exponent), hn::Load(d, inside));
      window->weight[tap] = weight;
      window->reference[tap] = value;
      sum_weights = hn::Add(sum_weights, weight);
      sum = hn::MulAdd(weight, value, sum);
    }
  }
  const V inverse =
      hn::Div(hn::Set(d, 1.0f), hn::Max(sum_weights, hn::Set(d, 1e-6f)));
  const V mean = hn::Mul(sum, inverse);
  window->variance = hn::Zero(d);
  for (int tap = 0; tap < window->num_taps; ++tap) {
    window->weight[tap] = hn::Mul(window->weight[tap], inverse);
    window->reference[tap] = hn::Sub(window->reference[tap], mean);
    window->variance =
        hn::MulAdd(window->weight[tap],
                   hn::Mul(window->reference[tap], window->reference[tap]),
                   window->variance);
  }
}

// One source per lane, seen from a vector of pixels: the point at (dx, dy) from
// the pixel, at inverse depth rho, lands at
// center + dx by_x + dy by_y + rho b, homogeneous.
struct PixelWarp {
  V center[3];
  V by_x[3];
  V by_y[3];
  V b[3];
  V max_u;        // largest pixel coordinates of the source at which its grey
  V max_v;        // values can be interpolated
  VI first_byte;  // of the source's grey values
  VI row_bytes;   // 0 marks an empty slot
};

HWY_INLINE PixelWarp MakePixelWarp(const WarpVector& warp,
                                   const V x,
                                   const V y) {
  const D d;
  PixelWarp result;
  for (int i = 0; i < 3; ++i) {
    result.by_x[i] = warp.h[3 * i];
    result.by_y[i] = warp.h[3 * i + 1];
    result.center[i] = hn::MulAdd(
        result.by_x[i], x, hn::MulAdd(result.by_y[i], y, warp.h[3 * i + 2]));
    result.b[i] = warp.b[i];
  }
  result.max_u = hn::Sub(warp.width, hn::Set(d, 1.0f + kBorder));
  result.max_v = hn::Sub(warp.height, hn::Set(d, 1.0f + kBorder));
  result.first_byte = hn::ShiftLeft<1>(warp.first_pixel);
  result.row_bytes = hn::ShiftLeft<1>(warp.stride);
  return result;
}

// The pixel coordinates, first pixel's centre at zero, of a homogeneous point.
HWY_INLINE void Project(const V* p, V* u, V* v) {
  const D d;
  const V guess = hn::ApproximateReciprocal(p[2]);
  const V inverse =  // Newton
      hn::Mul(guess, hn::NegMulAdd(p[2], guess, hn::Set(d, 2.0f)));
  *u = hn::MulSub(p[0], inverse, hn::Set(d, 0.5f));
  *v = hn::MulSub(p[1], inverse, hn::Set(d, 0.5f));
}

// Where the source sees the whole window. A plane's window lands in a convex
// quadrilateral, so its corners tell.
HWY_INLINE M SeesWindow(const PixelWarp& warp,
                        const Window& window,
                        const V* center,
                        const V* by_x,
                        const V* by_y) {
  const D d;
  const V border = hn::Set(d, kBorder);
  M result = hn::RebindMask(d, hn::Gt(warp.row_bytes, hn::Zero(DI())));
  const float ends[2] = {window.offset[0], window.offset[window.side - 1]};
  for (const float dy : ends) {
    for (const float dx : ends) {
      V p[3];
      for (int i = 0; i < 3; ++i) {
        p[i] = hn::MulAdd(by_x[i],
                          hn::Set(d, dx),
                          hn::MulAdd(by_y[i], hn::Set(d, dy), center[i]));
      }
      V u;
      V v;
      Project(p, &u, &v);
      result = hn::And(result, hn::Gt(p[2], hn::Set(d, kMinDepthRatio)));
      result =
          hn::And(result, hn::And(hn::Ge(u, border), hn::Lt(u, warp.max_u)));
      result =
          hn::And(result, hn::And(hn::Ge(v, border), hn::Lt(v, warp.max_v)));
    }
  }
  return result;
}

// Grey value in [0, kMaxGray] by bilinear interpolation. `brightest` becomes at
// least the brightest of the pixels read.
HWY_INLINE V InterpolateGray(const uint16_t* grays,
                             const PixelWarp& warp,
                             const V u,
                             const V v,
                             const M is_seen,
                             VI* brightest) {
  const D d;
  const DI di;
  const DU du;
  const VI x = hn::ConvertTo(di, u);
  const VI y = hn::ConvertTo(di, v);
  const V fu = hn::Sub(u, hn::ConvertTo(d, x));
  const V fv = hn::Sub(v, hn::ConvertTo(d, y));
  const VI top_byte = hn::IfThenElseZero(
      hn::RebindMask(di, is_seen),
      hn::Add(hn::Mul(y, warp.row_bytes),
              hn::Add(warp.first_byte, hn::ShiftLeft<1>(x))));
  const VI bottom_byte = hn::IfThenElseZero(hn::RebindMask(di, is_seen),
                                            hn::Add(top_byte, warp.row_bytes));
  // One 32-bit read holds two neighbours in a row.
  const int* const base = reinterpret_cast<const int*>(grays);
  const VI top = hn::GatherOffset(di, base, top_byte);
  const VI bottom = hn::GatherOffset(di, base, bottom_byte);
  const auto right = [&](const VI pair) HWY_ATTR {
    return hn::BitCast(di, hn::ShiftRight<16>(hn::BitCast(du, pair)));
  };
  const VI low = hn::Set(di, 0xffff);
  const VI i00 = hn::And(top, low);
  const VI i01 = right(top);
  const VI i10 = hn::And(bottom, low);
  const VI i11 = right(bottom);
  *brightest =
      hn::Max(*brightest, hn::Max(hn::Max(i00, i01), hn::Max(i10, i11)));
  const V v00 = hn::ConvertTo(d, i00);
  const V v10 = hn::ConvertTo(d, i10);
  const V top_value = hn::MulAdd(fu, hn::Sub(hn::ConvertTo(d, i01), v00), v00);
  const V bottom_value =
      hn::MulAdd(fu, hn::Sub(hn::ConvertTo(d, i11), v10), v10);
  return hn::MulAdd(fv, hn::Sub(bottom_value, top_value), top_value);
}

// One minus the correlation with one source per lane; kWorstCost where the
// source does not see the whole patch.
HWY_INLINE V SourceCost(const uint16_t* grays,
                        const PixelWarp& warp,
                        const Window& window,
                        const Planes& planes) {
  const D d;
  const DI di;
  const V one = hn::Set(d, 1.0f);
  V center[3];
  V by_x[3];
  V by_y[3];
  for (int i = 0; i < 3; ++i) {
    center[i] = hn::MulAdd(warp.b[i], planes.rho, warp.center[i]);
    by_x[i] = hn::MulAdd(warp.b[i], planes.rho_x, warp.by_x[i]);
    by_y[i] = hn::MulAdd(warp.b[i], planes.rho_y, warp.by_y[i]);
  }
  const M is_seen = SeesWindow(warp, window, center, by_x, by_y);
  if (hn::AllFalse(d, is_seen)) {
    return hn::Set(d, kWorstCost);
  }
  VI brightest = hn::Zero(di);
  V sum = hn::Zero(d);
  V sum_squares = hn::Zero(d);
  V covariance = hn::Zero(d);
  int tap = 0;
  for (int row = 0; row < window.side; ++row) {
    const V dy = hn::Set(d, window.offset[row]);
    V row_center[3];
    for (int i = 0; i < 3; ++i) {
      row_center[i] = hn::MulAdd(by_y[i], dy, center[i]);
    }
    for (int col = 0; col < window.side; ++col, ++tap) {
      const V dx = hn::Set(d, window.offset[col]);
      V p[3];
      for (int i = 0; i < 3; ++i) {
        p[i] = hn::MulAdd(by_x[i], dx, row_center[i]);
      }
      V u;
      V v;
      Project(p, &u, &v);
      const V value = InterpolateGray(grays, warp, u, v, is_seen, &brightest);
      const V weighted = hn::Mul(window.weight[tap], value);
      sum = hn::Add(sum, weighted);
      sum_squares = hn::MulAdd(weighted, value, sum_squares);
      covariance = hn::MulAdd(weighted, window.reference[tap], covariance);
    }
  }
  const V scale = hn::Set(d, kInverseMaxGray);
  sum = hn::Mul(sum, scale);
  sum_squares = hn::Mul(sum_squares, hn::Mul(scale, scale));
  covariance = hn::Mul(covariance, scale);
  // Values are in [0, 1] and weights sum to one, so this cancels to 1e-7 at
  // worst, far below the variance that counts as noise.
  const V variance = hn::Max(hn::NegMulAdd(sum, sum, sum_squares), hn::Zero(d));
  const V noise = hn::Set(d, kNoiseVariance);
  const V correlation =
      hn::Div(covariance,
              hn::Sqrt(hn::Mul(hn::Add(window.variance, noise),
                               hn::Add(variance, noise))));
  const M is_valid = hn::And(
      is_seen,
      hn::RebindMask(
          d, hn::Ne(brightest, hn::Set(di, TrainingViews::kMaskedGray))));
  return hn::IfThenElse(
      is_valid, hn::Sub(one, correlation), hn::Set(d, kWorstCost));
}

// Mean of the `count` smallest of costs[0 .. n), per lane; slots that see
// nothing are left out as long as others see something.
HWY_INLINE V MeanOfBest(V* costs, const int n, const int count) {
  const D d;
  V sum = hn::Zero(d);
  V sum_weights = hn::Zero(d);
  for (int k = 0; k < std::min(count, n); ++k) {
    for (int i = k + 1; i < n; ++i) {
      const V smaller = hn::Min(costs[k], costs[i]);
      costs[i] = hn::Max(costs[k], costs[i]);
      costs[k] = smaller;
    }
    const V weight = hn::IfThenElseZero(
        hn::Lt(costs[k], hn::Set(d, kWorstCost)), hn::Set(d, 1.0f));
    sum = hn::MulAdd(weight, costs[k], sum);
    sum_weights = hn::Add(sum_weights, weight);
  }
  return hn::IfThenElse(hn::Gt(sum_weights, hn::Zero(d)),
                        hn::Div(sum, hn::Max(sum_weights, hn::Set(d, 1.0f))),
                        hn::Set(d, kWorstCost));
}

}  // namespace HWY_NAMESPACE
}  // namespace structnerf
HWY_AFTER_NAMESPACE();

#endif  // NERF_STEREO_WINDOW_COST_INL_H_
