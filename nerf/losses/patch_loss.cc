#include "nerf/losses/patch_loss.h"

#include <algorithm>

// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nerf/losses/patch_loss.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
#include "nerf/losses/view_warp-inl.h"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace structnerf {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// Constants of SSIM (Wang et al. 2004) for values in [0, 1].
constexpr float kC1 = 1e-4f;
constexpr float kC2 = 9e-4f;

constexpr int kMaxTaps = kMaxPatchSide * kMaxPatchSide;

struct Taps {
  V reference[kMaxTaps];
  V reference_mean;
  V reference_variance;  // times the number of taps
  M is_complete;         // all inside the image and outside its mask
};

// Where the patch of a pixel at coordinate i of `size` is centred: at the
// pixel, or as near as it fits.
HWY_INLINE int PatchCenter(const int i, const int size, const int reach) {
  return std::max(std::min(i, size - 1 - reach), reach);
}

// Reads the patches of the views themselves around (col, row).
HWY_INLINE void ReadReference(const uint16_t* grays,
                              const TrainingViews& views,
                              const int radius,
                              const int dilation,
                              const int num_rays,
                              const int* view_idx,
                              const int* col,
                              const int* row,
                              Taps* taps) {
  const D d;
  HWY_ALIGN float values[kMaxTaps][16] = {};
  HWY_ALIGN float completeness[16] = {};
  const int reach = radius * dilation;
  for (int ray = 0; ray < num_rays; ++ray) {
    const TrainingViews::Image& image = views.image(view_idx[ray]);
    if (image.width <= 2 * reach || image.height <= 2 * reach) {
      continue;
    }
    bool is_masked = false;
    int tap = 0;
    for (int dy = -reach; dy <= reach; dy += dilation) {
      for (int dx = -reach; dx <= reach; dx += dilation, ++tap) {
        const uint16_t gray =
            grays[image.first_pixel +
                  static_cast<size_t>(row[ray] + dy) * image.width + col[ray] +
                  dx];
        is_masked |= gray == TrainingViews::kMaskedGray;
        values[tap][ray] = kInverseMaxGray * gray;
      }
    }
    completeness[ray] = is_masked ? 0.0f : 1.0f;
  }
  taps->is_complete = hn::Gt(hn::Load(d, completeness), hn::Zero(d));
  const int num_taps = (2 * radius + 1) * (2 * radius + 1);
  V sum = hn::Zero(d);
  for (int tap = 0; tap < num_taps; ++tap) {
    taps->reference[tap] = hn::Load(d, values[tap]);
    sum = hn::Add(sum, taps->reference[tap]);
  }
  taps->reference_mean =
      hn::Mul(sum, hn::Set(d, 1.0f / static_cast<float>(num_taps)));
  taps->reference_variance = hn::Zero(d);
  for (int tap = 0; tap < num_taps; ++tap) {
    // Centred once and for all: only differences to the mean are used, and the
    // mean can be added back for L1.
    taps->reference[tap] = hn::Sub(taps->reference[tap], taps->reference_mean);
    taps->reference_variance = hn::MulAdd(
        taps->reference[tap], taps->reference[tap], taps->reference_variance);
  }
}

// Warps the patch into one source and compares. `warp_index` holds each lane's
// index into warps.
HWY_INLINE void CompareWithSource(const ViewWarp* warps,
                                  const VI warp_index,
                                  const uint16_t* grays,
                                  const PatchLoss::Options& options,
                                  const V x,
                                  const V y,
                                  const V rho,
                                  const Taps& taps,
                                  V* loss,
                                  V* by_rho,
                                  M* is_valid) {
  const D d;
  const WarpVector warp = GatherWarps(warps, warp_index);
  V center[3];  // of the patch, homogeneous
  for (int i = 0; i < 3; ++i) {
    center[i] =
        hn::MulAdd(warp.h[3 * i],
                   x,
                   hn::MulAdd(warp.h[3 * i + 1],
                              y,
                              hn::MulAdd(warp.b[i], rho, warp.h[3 * i + 2])));
  }

  const V zero = hn::Zero(d);
  const V half = hn::Set(d, 0.5f);
  const V one = hn::Set(d, 1.0f);
  M valid = hn::RebindMask(d, hn::Gt(warp.stride, hn::Zero(DI())));
  V value[kMaxTaps];
  V derivative[kMaxTaps];
  V sum = zero;
  int tap = 0;
  for (int ty = -options.radius; ty <= options.radius; ++ty) {
    for (int tx = -options.radius; tx <= options.radius; ++tx, ++tap) {
      const V dx = hn::Set(d, static_cast<float>(tx * options.dilation));
      const V dy = hn::Set(d, static_cast<float>(ty * options.dilation));
      V p[3];
      for (int i = 0; i < 3; ++i) {
        p[i] = hn::MulAdd(
            warp.h[3 * i], dx, hn::MulAdd(warp.h[3 * i + 1], dy, center[i]));
      }
      valid = hn::And(valid, hn::Gt(p[2], hn::Set(d, kMinDepthRatio)));
      const V inverse = hn::Div(one, hn::Max(p[2], hn::Set(d, kMinDepthRatio)));
      const V u = hn::Mul(p[0], inverse);
      const V v = hn::Mul(p[1], inverse);
      const V pixel_u = hn::Sub(u, half);
      const V pixel_v = hn::Sub(v, half);
      valid = hn::And(valid, IsInside(warp, pixel_u, pixel_v));
      V by_u;
      V by_v;
      M unmasked;
      value[tap] = Bilinear(grays,
                            warp,
                            hn::IfThenElseZero(valid, pixel_u),
                            hn::IfThenElseZero(valid, pixel_v),
                            valid,
                            &by_u,
                            &by_v,
                            &unmasked);
      valid = hn::And(valid, unmasked);
      const V u_by_rho =
          hn::Mul(hn::NegMulAdd(u, warp.b[2], warp.b[0]), inverse);
      const V v_by_rho =
          hn::Mul(hn::NegMulAdd(v, warp.b[2], warp.b[1]), inverse);
      derivative[tap] = hn::MulAdd(by_u, u_by_rho, hn::Mul(by_v, v_by_rho));
      sum = hn::Add(sum, value[tap]);
    }
  }

  const int num_taps = tap;
  const V inverse_count = hn::Set(d, 1.0f / static_cast<float>(num_taps));
  const V mean = hn::Mul(sum, inverse_count);
  V variance = zero;
  V covariance = zero;
  V absolute = zero;
  V sum_derivative = zero;
  V variance_by_rho = zero;  // halved
  V covariance_by_rho = zero;
  V absolute_by_rho = zero;
  for (int t = 0; t < num_taps; ++t) {
    const V centered = hn::Sub(value[t], mean);
    variance = hn::MulAdd(centered, centered, variance);
    covariance = hn::MulAdd(centered, taps.reference[t], covariance);
    variance_by_rho = hn::MulAdd(centered, derivative[t], variance_by_rho);
    covariance_by_rho =
        hn::MulAdd(taps.reference[t], derivative[t], covariance_by_rho);
    sum_derivative = hn::Add(sum_derivative, derivative[t]);
    const V difference =
        hn::Sub(value[t], hn::Add(taps.reference[t], taps.reference_mean));
    absolute = hn::Add(absolute, hn::Abs(difference));
    absolute_by_rho = hn::Add(
        absolute_by_rho,
        hn::CopySign(derivative[t], hn::Xor(derivative[t], difference)));
  }
  const V c1 = hn::Set(d, kC1);
  const V c2 = hn::Set(d, kC2);
  const V two = hn::Set(d, 2.0f);
  const V mean_x = taps.reference_mean;
  const V a1 = hn::MulAdd(two, hn::Mul(mean_x, mean), c1);
  const V a2 = hn::MulAdd(two, hn::Mul(covariance, inverse_count), c2);
  const V b1 = hn::MulAdd(mean_x, mean_x, hn::MulAdd(mean, mean, c1));
  const V b2 =
      hn::MulAdd(hn::Add(taps.reference_variance, variance), inverse_count, c2);
  const V inverse_b = hn::Div(one, hn::Mul(b1, b2));
  const V ssim = hn::Mul(hn::Mul(a1, a2), inverse_b);
  const V ssim_by_mean =
      hn::Sub(hn::Mul(hn::Mul(two, mean_x), hn::Mul(a2, inverse_b)),
              hn::Div(hn::Mul(ssim, hn::Mul(two, mean)), b1));
  const V ssim_by_covariance = hn::Mul(two, hn::Mul(a1, inverse_b));
  const V ssim_by_variance = hn::Neg(hn::Div(ssim, b2));
  const V ssim_by_rho = hn::Mul(
      inverse_count,
      hn::MulAdd(ssim_by_mean,
                 sum_derivative,
                 hn::MulAdd(hn::Mul(two, ssim_by_variance),
                            variance_by_rho,
                            hn::Mul(ssim_by_covariance, covariance_by_rho))));

  const V share = hn::Set(d, options.ssim_share);
  const V l1_share =
      hn::Mul(hn::Set(d, 1.0f - options.ssim_share), inverse_count);
  *loss = hn::MulAdd(
      hn::Mul(share, half), hn::Sub(one, ssim), hn::Mul(l1_share, absolute));
  *by_rho = hn::NegMulAdd(
      hn::Mul(share, half), ssim_by_rho, hn::Mul(l1_share, absolute_by_rho));
  *is_valid = valid;
}

// Losses of up to one vector of rays in all their sources: slots x 16.
void CompareSources(const ViewWarp* warps,
                    const int num_slots,
                    const TrainingViews& views,
                    const PatchLoss::Options& options,
                    const int num_rays,
                    const int* view_idx,
                    const int* col,
                    const int* row,
                    const float* depth,
                    float* losses,
                    float* by_rho,
                    int* valid) {
  const D d;
  const DI di;
  int center_col[16];
  int center_row[16];
  HWY_ALIGN float x[16] = {};
  HWY_ALIGN float y[16] = {};
  HWY_ALIGN float rho[16] = {};
  HWY_ALIGN int first_warp[16] = {};
  const int reach = options.radius * options.dilation;
  for (int ray = 0; ray < num_rays; ++ray) {
    const TrainingViews::Image& image = views.image(view_idx[ray]);
    center_col[ray] = PatchCenter(col[ray], image.width, reach);
    center_row[ray] = PatchCenter(row[ray], image.height, reach);
    x[ray] = static_cast<float>(center_col[ray]) + 0.5f;
    y[ray] = static_cast<float>(center_row[ray]) + 0.5f;
    rho[ray] = 1.0f / depth[ray];
    first_warp[ray] = view_idx[ray] * num_slots;
  }
  Taps taps;
  ReadReference(views.Grays(),
                views,
                options.radius,
                options.dilation,
                num_rays,
                view_idx,
                center_col,
                center_row,
                &taps);
  HWY_ALIGN float validity[16] = {};
  for (int slot = 0; slot < num_slots; ++slot) {
    const VI warp_index = hn::Add(hn::Load(di, first_warp), hn::Set(di, slot));
    V slot_loss;
    V slot_by_rho;
    M slot_valid;
    CompareWithSource(warps,
                      warp_index,
                      views.Grays(),
                      options,
                      hn::Load(d, x),
                      hn::Load(d, y),
                      hn::Load(d, rho),
                      taps,
                      &slot_loss,
                      &slot_by_rho,
                      &slot_valid);
    hn::StoreU(slot_loss, d, losses + slot * 16);
    hn::StoreU(slot_by_rho, d, by_rho + slot * 16);
    slot_valid = hn::And(slot_valid, taps.is_complete);
    hn::Store(hn::IfThenElseZero(slot_valid, hn::Set(d, 1.0f)), d, validity);
    for (int ray = 0; ray < num_rays; ++ray) {
      valid[slot * 16 + ray] = validity[ray] > 0;
    }
  }
}

size_t RaysPerVector() { return hn::Lanes(D()); }

}  // namespace HWY_NAMESPACE
}  // namespace structnerf
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace structnerf {

HWY_EXPORT(CompareSources);
HWY_EXPORT(RaysPerVector);

PatchLoss::PatchLoss(const Scene& scene,
                     const SceneFrame& frame,
                     const TrainingViews& views,
                     const std::vector<std::vector<int>>& sources,
                     const Options& options)
    : views_(views),
      options_(options),
      source_warps_(MakeSourceWarps(scene, frame, views, sources)) {}

void PatchLoss::Evaluate(const int num_rays,
                         const int* view_idx,
                         const int* col,
                         const int* row,
                         const float* depth,
                         float* loss,
                         float* d_depth,
                         int* num_valid) const {
  float losses[kMaxSourceSlots * 16];
  float by_rho[kMaxSourceSlots * 16];
  int valid[kMaxSourceSlots * 16];
  const int step = static_cast<int>(HWY_DYNAMIC_DISPATCH(RaysPerVector)());
  for (int begin = 0; begin < num_rays; begin += step) {
    const int size = std::min(step, num_rays - begin);
    HWY_DYNAMIC_DISPATCH(CompareSources)
    (source_warps_.warps.data(),
     source_warps_.num_slots,
     views_,
     options_,
     size,
     view_idx + begin,
     col + begin,
     row + begin,
     depth + begin,
     losses,
     by_rho,
     valid);
    for (int ray = 0; ray < size; ++ray) {
      int order[kMaxSourceSlots];
      int count = 0;
      for (int slot = 0; slot < source_warps_.num_slots; ++slot) {
        if (valid[slot * 16 + ray]) {
          order[count++] = slot * 16 + ray;
        }
      }
      const int num_used = std::min(count, options_.num_best);
      std::partial_sort(
          order,
          order + num_used,
          order + count,
          [&](const int a, const int b) { return losses[a] < losses[b]; });
      float sum = 0;
      float sum_by_rho = 0;
      for (int i = 0; i < num_used; ++i) {
        sum += losses[order[i]];
        sum_by_rho += by_rho[order[i]];
      }
      const float inverse = num_used > 0 ? 1.0f / num_used : 0.0f;
      const float rho = 1.0f / depth[begin + ray];
      loss[begin + ray] = sum * inverse;
      d_depth[begin + ray] = -rho * (rho * sum_by_rho) * inverse;
      num_valid[begin + ray] = count;
    }
  }
}

}  // namespace structnerf
#endif  // HWY_ONCE
