#include "nerf/kernels/color_compositing.h"

#include "nerf/field/field_layout.h"
#include "tests/nerf/random_values.h"
#include "tests/nerf/simd_targets.h"
#include "tests/support/numeric_gradient.h"

#include <cmath>
#include <vector>

namespace structnerf {
namespace {

constexpr size_t kNumRays = 4;
constexpr size_t kNumSamples = 20;

class ColorCompositingTest : public SimdTargetTest {
 protected:
  ColorCompositingTest()
      : weight_(RandomValues(kNumSamples, 0.01f, 1, 1)),
        logits_(RandomValues(kNumSamples * kColorOutputWidth, -2, 2, 2)) {
    // Ray 2 has no active samples, sample 3 is not active.
    for (uint32_t s = 0; s < kNumSamples; ++s) {
      const uint32_t ray = s / 5;
      if (ray != 2 && s != 3) {
        samples_.push_back(s);
        rays_.push_back(ray);
      }
    }
    color_ = logits_;
    for (float& color : color_) {
      color = 1 / (1 + std::exp(-color));
    }
  }

  ActiveColors Active() const {
    return {samples_.size(),
            samples_.data(),
            rays_.data(),
            color_.data(),
            weight_.data()};
  }

  // Channel c of a ray for other weights and other logits of active samples.
  double Expected(const size_t ray,
                  const int c,
                  const std::vector<double>& weight,
                  const std::vector<double>& logits) const {
    double sum = 0;
    double sum_weight = 0;
    for (size_t a = 0; a < samples_.size(); ++a) {
      if (rays_[a] == ray) {
        sum += weight[samples_[a]] /
               (1 + std::exp(-logits[a * kColorOutputWidth + c]));
        sum_weight += weight[samples_[a]];
      }
    }
    return sum_weight > 0 ? sum / sum_weight : 0.0;
  }

  std::vector<float> weight_;
  std::vector<float> logits_;
  std::vector<float> color_;
  std::vector<uint32_t> samples_;
  std::vector<uint32_t> rays_;
};

TEST_P(ColorCompositingTest, Forward) {
  std::vector<float> ray_color(kNumRays * kRayColorWidth, 7.0f);
  CompositeColor(Active(), kNumRays, ray_color.data());
  const std::vector<double> weight(weight_.begin(), weight_.end());
  const std::vector<double> logits(logits_.begin(), logits_.end());
  for (size_t ray = 0; ray < kNumRays; ++ray) {
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(ray_color[ray * kRayColorWidth + c],
                  Expected(ray, c, weight, logits),
                  1e-6);
    }
    float sum_weight = 0;
    for (size_t a = 0; a < samples_.size(); ++a) {
      sum_weight += rays_[a] == ray ? weight_[samples_[a]] : 0.0f;
    }
    EXPECT_NEAR(ray_color[ray * kRayColorWidth + 3], sum_weight, 1e-6);
  }
}

TEST_P(ColorCompositingTest, Backward) {
  std::vector<float> ray_color(kNumRays * kRayColorWidth);
  CompositeColor(Active(), kNumRays, ray_color.data());
  std::vector<float> d_ray_color =
      RandomValues(kNumRays * kRayColorWidth, -1, 1, 3);
  for (size_t ray = 0; ray < kNumRays; ++ray) {
    d_ray_color[ray * kRayColorWidth + 3] = 0;
  }
  constexpr float kUntouched = 7.0f;
  std::vector<float> d_weight(kNumSamples, kUntouched);
  std::vector<float> d_color(samples_.size() * kColorOutputWidth, kUntouched);
  CompositeColorBackward(Active(),
                         ray_color.data(),
                         d_ray_color.data(),
                         d_weight.data(),
                         d_color.data());

  const std::vector<double> weight(weight_.begin(), weight_.end());
  const std::vector<double> logits(logits_.begin(), logits_.end());
  const auto loss = [&](const std::vector<double>& w,
                        const std::vector<double>& x) {
    double sum = 0;
    for (size_t ray = 0; ray < kNumRays; ++ray) {
      for (int c = 0; c < 3; ++c) {
        sum += d_ray_color[ray * kRayColorWidth + c] * Expected(ray, c, w, x);
      }
    }
    return sum;
  };
  const auto by_weight = NumericGradient(
      [&](const std::vector<double>& w) { return loss(w, logits); }, weight);
  const auto by_logit = NumericGradient(
      [&](const std::vector<double>& x) { return loss(weight, x); }, logits);
  std::vector<bool> is_active(kNumSamples);
  for (size_t a = 0; a < samples_.size(); ++a) {
    is_active[samples_[a]] = true;
    EXPECT_NEAR(d_weight[samples_[a]], by_weight[samples_[a]], 2e-6);
    for (int c = 0; c < kColorOutputWidth; ++c) {
      const size_t i = a * kColorOutputWidth + c;
      if (c < 3) {
        EXPECT_NEAR(d_color[i], by_logit[i], 1e-6);
      } else {
        EXPECT_EQ(d_color[i], c == 3 ? 0.0f : kUntouched);
      }
    }
  }
  for (size_t s = 0; s < kNumSamples; ++s) {
    if (!is_active[s]) {
      EXPECT_EQ(d_weight[s], kUntouched);
    }
  }
}

STRUCTNERF_FOR_EACH_SIMD_TARGET(ColorCompositingTest);

}  // namespace
}  // namespace structnerf
