// Losses of the depth of single rays in float against their formulas in double.

#include "nerf/losses/depth_likelihood.h"
#include "nerf/losses/far_push.h"
#include "nerf/losses/sparse_loss.h"
#include "nerf/util/random.h"
#include "tests/stability/loss_error.h"
#include "tests/stability/stability_case.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

namespace structnerf {
namespace {

std::string MeasureFarTerm() {
  LossError error;
  for (const int blankness : {0, 1, 128, 255}) {
    for (double depth = 1e-30; depth < 1e30; depth *= 3) {
      float d_depth = 0;
      const float d = static_cast<float>(depth);
      const double loss =
          EvaluateFarPush(static_cast<uint8_t>(blankness), d, &d_depth);
      const double weight = blankness / 255.0;
      error.value = std::max(
          error.value, std::abs(loss + weight * std::log(double{d})) / 70);
      error.gradient =
          std::max(error.gradient, std::abs(d_depth * double{d} + weight));
    }
  }
  return Accept(error, 1e-6, 1e-6);
}

// Of a prior 0.3 units behind what is rendered, or as far as that is.
std::string MeasureDepthLikelihood() {
  constexpr float kUnit = 0.2f;
  LossError error;
  for (double depth = 1e-8; depth < 1e3; depth *= 1.5) {
    for (const double deviation : {0.0, 1e-6, 1e-3, 1.0}) {
      RayOutputs outputs = {};
      outputs.depth[0] = static_cast<float>(depth);
      outputs.depth_variance[0] =
          static_cast<float>(std::pow(deviation * depth, 2));
      PriorDepth prior;
      prior.depth =
          static_cast<float>(depth + std::min<double>(0.3 * kUnit, depth));
      prior.deviation = 1e-9f;
      RayGradients gradients = {};
      const double loss = EvaluateDepthLikelihood(
          prior, /*weight=*/1, kUnit, outputs, 0, &gradients);
      const double offset = (double{outputs.depth[0]} - prior.depth) / kUnit;
      const double variance =
          double{outputs.depth_variance[0]} / kUnit / kUnit + 1e-6;
      error.value = std::max(
          error.value,
          RelativeError(loss, std::log(variance) + offset * offset / variance));
      error.gradient = std::max(
          {error.gradient,
           RelativeError(gradients.d_depth[0], 2 * offset / variance / kUnit),
           RelativeError(gradients.pull[0],
                         (1 / variance - std::pow(offset / variance, 2)) *
                             std::pow(outputs.depth[0] / kUnit, 2))});
    }
  }
  return Accept(error, 1e-5, 1e-4);
}

// Of a sparse point as far in front of what is rendered as behind it.
std::string MeasureSquaredDepth() {
  constexpr float kUnit = 0.2f;
  LossError error;
  for (double depth = 1e-8; depth < 1e15; depth *= 1.7) {
    for (const double ratio : {1e-6, 0.5, 0.999999, 1.0, 1.5, 1e3}) {
      SparseTarget target;
      target.depth = static_cast<float>(depth * ratio);
      target.weight = 1;
      RayOutputs outputs = {};
      outputs.depth[0] = static_cast<float>(depth);
      RayGradients gradients = {};
      const double loss =
          EvaluateSquaredDepth(target, kUnit, outputs, 0, &gradients);
      const double offset =
          (double{outputs.depth[0]} - double{target.depth}) / kUnit;
      error.value = std::max(error.value, RelativeError(loss, offset * offset));
      error.gradient =
          std::max(error.gradient,
                   RelativeError(gradients.d_depth[0], 2 * offset / kUnit));
    }
  }
  return Accept(error, 1e-6, 1e-6);
}

// Light that ends at two places around the depth of a sparse point, or at only
// one of them.
std::string MeasureLineOfSight() {
  LossError error;
  for (double depth = 1e-15; depth < 1e15; depth *= 1.7) {
    for (const double ratio : {1e-6, 0.5, 0.999999, 1.0, 1.5, 1e3}) {
      for (const double share : {0.0, 1e-6, 0.5, 1.0}) {
        SparseTarget target;
        target.depth = static_cast<float>(depth);
        target.weight = 0.1f;
        const double z[2] = {depth * ratio, depth * 1.1};
        const double mean = share * z[0] + (1 - share) * z[1];
        RayOutputs outputs = {};
        outputs.depth[0] = static_cast<float>(mean);
        outputs.depth_variance[0] =
            static_cast<float>(share * (1 - share) * std::pow(z[0] - z[1], 2));
        RayGradients gradients = {};
        const double loss =
            EvaluateLineOfSight(target, outputs, 0, &gradients) / target.weight;
        const auto squared = [&](const int place) {
          return std::pow((z[place] - target.depth) / target.depth, 2);
        };
        error.value = std::max(
            error.value,
            RelativeError(loss, share * squared(0) + (1 - share) * squared(1)));
        // The derivative by the share of light at one of the places.
        const double slope =
            gradients.pull[0] / target.weight *
            std::pow((z[0] - gradients.pull_z[0]) / gradients.pull_z[0], 2);
        error.gradient =
            std::max(error.gradient, RelativeError(slope, squared(0)));
      }
    }
  }
  return Accept(error, 1e-6, 1e-6);
}

// Light that ends anywhere, or nowhere near the sparse point.
std::string MeasureRayTermination() {
  constexpr int kNumSamples = 24;
  Random random(4);
  LossError error;
  for (double deviation = 1e-9; deviation < 1e9; deviation *= 10) {
    for (const float opaque_share : {0.0f, 1e-20f, 0.5f, 1.0f}) {
      std::vector<float> edges = {0.02f};
      std::vector<float> weight;
      for (int i = 0; i < kNumSamples; ++i) {
        edges.push_back(edges.back() * (1 + 0.5f * random.NextFloat()));
        weight.push_back(opaque_share / kNumSamples);
      }
      weight.back() += 1 - opaque_share;
      SparseTarget target;
      target.depth =
          edges.front() + random.NextFloat() * (edges.back() - edges.front());
      target.deviation = static_cast<float>(deviation);
      target.weight = 1;
      std::vector<float> d_weight(kNumSamples, 0);
      const RaySamples samples = {kNumSamples, edges.data(), weight.data()};
      const double loss =
          EvaluateRayTermination(target, samples, 0, d_weight.data());
      double expected = 0;
      double below = 0;
      for (int i = 0; i < kNumSamples; ++i) {
        const double x = (double{edges[i + 1]} - double{target.depth}) /
                         double{target.deviation};
        const double up_to =
            i == kNumSamples - 1 ? 1 : 0.5 * std::erfc(-x * M_SQRT1_2);
        const double share = up_to - below;
        below = up_to;
        expected -= share * std::log(double{weight[i]} + 1e-5);
        error.gradient = std::max(
            error.gradient,
            std::abs(d_weight[i] * (double{weight[i]} + 1e-5) + share));
      }
      error.value = std::max(error.value, RelativeError(loss, expected));
    }
  }
  return Accept(error, 1e-5, 1e-5);
}

}  // namespace

std::vector<StabilityCase> DepthLossCases() {
  return {{"far term: depths of 1e-30 to 1e30", MeasureFarTerm},
          {"likelihood of depth priors: depths of 1e-8 to 1e3",
           MeasureDepthLikelihood},
          {"squared sparse loss: depths of 1e-8 to 1e15", MeasureSquaredDepth},
          {"line of sight: depths of 1e-15 to 1e15", MeasureLineOfSight},
          {"ray termination loss: deviations of 1e-9 to 1e9",
           MeasureRayTermination}};
}

}  // namespace structnerf
