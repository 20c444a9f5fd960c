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

// Where a plane's window lands in a source: pixel coordinates, first pixel's
// centre at zero, of the window's centre, and their change per pixel of the
// window.
struct Landing {
  V u;
  V v;
  V u_by_x;
  V u_by_y;
  V v_by_x;
  V v_by_y;
  M is_seen;  // the whole window
};

// To first order around the centre, which spares a division per tap. What is
// left out is a twentieth of a pixel at the corner of a window where the source
// is turned by 30 degrees, and nothing where plane and images are parallel.
HWY_INLINE Landing Land(const PixelWarp& warp,
                        const Window& window,
                        const Planes& planes) {
  const D d;
  V center[3];
  V by_x[3];
  V by_y[3];
  for (int i = 0; i < 3; ++i) {
    center[i] = hn::MulAdd(warp.b[i], planes.rho, warp.center[i]);
    by_x[i] = hn::MulAdd(warp.b[i], planes.rho_x, warp.by_x[i]);
    by_y[i] = hn::MulAdd(warp.b[i], planes.rho_y, warp.by_y[i]);
  }
  const V one = hn::Set(d, 1.0f);
  const V half = hn::Set(d, 0.5f);
  const M is_in_front = hn::Gt(center[2], hn::Set(d, kMinDepthRatio));
  const V inverse = hn::Div(one, hn::IfThenElse(is_in_front, center[2], one));
  const V u = hn::Mul(center[0], inverse);
  const V v = hn::Mul(center[1], inverse);
  Landing landing;
  landing.u = hn::Sub(u, half);
  landing.v = hn::Sub(v, half);
  landing.u_by_x = hn::Mul(hn::NegMulAdd(u, by_x[2], by_x[0]), inverse);
  landing.u_by_y = hn::Mul(hn::NegMulAdd(u, by_y[2], by_y[0]), inverse);
  landing.v_by_x = hn::Mul(hn::NegMulAdd(v, by_x[2], by_x[1]), inverse);
  landing.v_by_y = hn::Mul(hn::NegMulAdd(v, by_y[2], by_y[1]), inverse);
  // A parallelogram is inside if its corners are.
  const V reach =
      hn::Set(d, std::max(-window.offset[0], window.offset[window.side - 1]));
  const V reach_u =
      hn::Mul(reach, hn::Add(hn::Abs(landing.u_by_x), hn::Abs(landing.u_by_y)));
  const V reach_v =
      hn::Mul(reach, hn::Add(hn::Abs(landing.v_by_x), hn::Abs(landing.v_by_y)));
  const V border = hn::Set(d, kBorder);
  const M is_inside_u =
      hn::And(hn::Ge(hn::Sub(landing.u, reach_u), border),
              hn::Lt(hn::Add(landing.u, reach_u), warp.max_u));
  const M is_inside_v =
      hn::And(hn::Ge(hn::Sub(landing.v, reach_v), border),
              hn::Lt(hn::Add(landing.v, reach_v), warp.max_v));
  const M is_there = hn::RebindMask(d, hn::Gt(warp.row_bytes, hn::Zero(DI())));
  landing.is_seen = hn::And(hn::And(is_there, is_in_front),
                            hn::And(is_inside_u, is_inside_v));
  return landing;
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
  const Landing landing = Land(warp, window, planes);
  if (hn::AllFalse(d, landing.is_seen)) {
    return hn::Set(d, kWorstCost);
  }
  VI brightest = hn::Zero(di);
  V sum = hn::Zero(d);
  V sum_squares = hn::Zero(d);
  V covariance = hn::Zero(d);
  int tap = 0;
  for (int row = 0; row < window.side; ++row) {
    const V dy = hn::Set(d, window.offset[row]);
    const V row_u = hn::MulAdd(landing.u_by_y, dy, landing.u);
    const V row_v = hn::MulAdd(landing.v_by_y, dy, landing.v);
    for (int col = 0; col < window.side; ++col, ++tap) {
      const V dx = hn::Set(d, window.offset[col]);
      const V value = InterpolateGray(grays,
                                      warp,
                                      hn::MulAdd(landing.u_by_x, dx, row_u),
                                      hn::MulAdd(landing.v_by_x, dx, row_v),
                                      landing.is_seen,
                                      &brightest);
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
      landing.is_seen,
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
