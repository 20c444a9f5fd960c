#include "nerf/kernels/color_compositing.h"

#include "nerf/field/field_layout.h"

// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nerf/kernels/color_compositing.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace structnerf {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<float, kRayColorWidth>;

void Composite(const ActiveColors& active,
               const size_t num_rays,
               float* HWY_RESTRICT ray_color) {
  const D d;
  const size_t lanes = hn::Lanes(d);
  for (size_t i = 0; i < num_rays * kRayColorWidth; i += lanes) {
    hn::StoreU(hn::Zero(d), d, ray_color + i);
  }
  for (size_t a = 0; a < active.count; ++a) {
    const float weight = active.weight[active.samples[a]];
    float* const sum = ray_color + active.rays[a] * kRayColorWidth;
    const float sum_weight = sum[3] + weight;
    for (size_t c = 0; c < kRayColorWidth; c += lanes) {
      const auto color = hn::LoadU(d, active.color + a * kColorOutputWidth + c);
      hn::StoreU(hn::MulAdd(hn::Set(d, weight), color, hn::LoadU(d, sum + c)),
                 d,
                 sum + c);
    }
    sum[3] = sum_weight;
  }
  for (size_t ray = 0; ray < num_rays; ++ray) {
    float* const color = ray_color + ray * kRayColorWidth;
    if (color[3] != 0) {
      for (int c = 0; c < 3; ++c) {
        color[c] /= color[3];
      }
    }
  }
}

void CompositeBackward(const ActiveColors& active,
                       const float* HWY_RESTRICT ray_color,
                       const float* HWY_RESTRICT d_ray_color,
                       float* HWY_RESTRICT d_weight,
                       float* HWY_RESTRICT d_color) {
  const D d;
  const size_t lanes = hn::Lanes(d);
  const auto one = hn::Set(d, 1.0f);
  for (size_t a = 0; a < active.count; ++a) {
    const size_t row = active.rays[a] * kRayColorWidth;
    const auto share = hn::Set(d, 1.0f / ray_color[row + 3]);
    const auto weight = hn::Set(d, active.weight[active.samples[a]]);
    auto d_weight_sum = hn::Zero(d);
    for (size_t c = 0; c < kRayColorWidth; c += lanes) {
      const auto color = hn::LoadU(d, active.color + a * kColorOutputWidth + c);
      const auto gradient = hn::Mul(share, hn::LoadU(d, d_ray_color + row + c));
      d_weight_sum =
          hn::MulAdd(gradient,
                     hn::Sub(color, hn::LoadU(d, ray_color + row + c)),
                     d_weight_sum);
      // Through the sigmoid.
      const auto slope = hn::Mul(color, hn::Sub(one, color));
      hn::StoreU(hn::Mul(hn::Mul(weight, gradient), slope),
                 d,
                 d_color + a * kColorOutputWidth + c);
    }
    d_weight[active.samples[a]] = hn::GetLane(hn::SumOfLanes(d, d_weight_sum));
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace structnerf
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace structnerf {

HWY_EXPORT(Composite);
HWY_EXPORT(CompositeBackward);

void CompositeColor(const ActiveColors& active,
                    const size_t num_rays,
                    float* ray_color) {
  HWY_DYNAMIC_DISPATCH(Composite)(active, num_rays, ray_color);
}

void CompositeColorBackward(const ActiveColors& active,
                            const float* ray_color,
                            const float* d_ray_color,
                            float* d_weight,
                            float* d_color) {
  HWY_DYNAMIC_DISPATCH(CompositeBackward)
  (active, ray_color, d_ray_color, d_weight, d_color);
}

}  // namespace structnerf
#endif  // HWY_ONCE
