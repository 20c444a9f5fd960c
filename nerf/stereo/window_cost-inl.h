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

constexpr int kMaxWindowTaps = 121;

// Fall-off of a tap's weight with its difference in grey value to the centre,
// and with its distance in units of the window's radius.
constexpr float kColorFalloff = 0.12f;
constexpr float kSpaceFalloff = 1.0f;

// Variance in grey value (of [0, 1]) below which a patch has no texture: noise
// of about one grey level.
constexpr float kNoiseVariance = 1.5e-5f;

constexpr float kWorstCost = 2.0f;

// Taps of the view itself: weights sum to one, values have mean zero.
struct Window {
  int num_taps = 0;
  float dx[kMaxWindowTaps];
  float dy[kMaxWindowTaps];
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
      window->dx[tap] = static_cast<float>(dx);
      window->dy[tap] = static_cast<float>(dy);
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

// One minus the correlation with one source per lane; kWorstCost where the
// source does not see the whole patch.
HWY_INLINE V SourceCost(const uint16_t* grays,
                        const WarpVector& warp,
                        const Window& window,
                        const V x,
                        const V y,
                        const Planes& planes) {
  const D d;
  const V one = hn::Set(d, 1.0f);
  const V half = hn::Set(d, 0.5f);
  V center[3];
  V by_x[3];
  V by_y[3];
  for (int i = 0; i < 3; ++i) {
    center[i] = hn::MulAdd(
        warp.h[3 * i],
        x,
        hn::MulAdd(warp.h[3 * i + 1],
                   y,
                   hn::MulAdd(warp.b[i], planes.rho, warp.h[3 * i + 2])));
    by_x[i] = hn::MulAdd(warp.b[i], planes.rho_x, warp.h[3 * i]);
    by_y[i] = hn::MulAdd(warp.b[i], planes.rho_y, warp.h[3 * i + 1]);
  }
  M valid = hn::RebindMask(d, hn::Gt(warp.stride, hn::Zero(DI())));
  V sum = hn::Zero(d);
  V sum_squares = hn::Zero(d);
  V covariance = hn::Zero(d);
  for (int tap = 0; tap < window.num_taps; ++tap) {
    const V dx = hn::Set(d, window.dx[tap]);
    const V dy = hn::Set(d, window.dy[tap]);
    V p[3];
    for (int i = 0; i < 3; ++i) {
      p[i] = hn::MulAdd(by_x[i], dx, hn::MulAdd(by_y[i], dy, center[i]));
    }
    valid = hn::And(valid, hn::Gt(p[2], hn::Set(d, kMinDepthRatio)));
    const V inverse = hn::Div(one, hn::Max(p[2], hn::Set(d, kMinDepthRatio)));
    const V u = hn::MulSub(p[0], inverse, half);
    const V v = hn::MulSub(p[1], inverse, half);
    valid = hn::And(valid, IsInside(warp, u, v));
    if (hn::AllFalse(d, valid)) {
      return hn::Set(d, kWorstCost);
    }
    V by_u;
    V by_v;
    M unmasked;
    const V value = Bilinear(grays,
                             warp,
                             hn::IfThenElseZero(valid, u),
                             hn::IfThenElseZero(valid, v),
                             valid,
                             &by_u,
                             &by_v,
                             &unmasked);
    valid = hn::And(valid, unmasked);
    const V weighted = hn::Mul(window.weight[tap], value);
    sum = hn::Add(sum, weighted);
    sum_squares = hn::MulAdd(weighted, value, sum_squares);
    covariance = hn::MulAdd(weighted, window.reference[tap], covariance);
  }
  // Values are in [0, 1] and weights sum to one, so this cancels to 1e-7 at
  // worst, far below the variance that counts as noise.
  const V variance = hn::Max(hn::NegMulAdd(sum, sum, sum_squares), hn::Zero(d));
  const V noise = hn::Set(d, kNoiseVariance);
  const V correlation =
      hn::Div(covariance,
              hn::Sqrt(hn::Mul(hn::Add(window.variance, noise),
                               hn::Add(variance, noise))));
  return hn::IfThenElse(
      valid, hn::Sub(one, correlation), hn::Set(d, kWorstCost));
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
