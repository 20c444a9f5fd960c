// Losses between pixels in float against their formulas in double, over all
// depths that a scene can have.

#include "nerf/losses/planar_loss.h"
#include "nerf/losses/triple_product.h"
#include "nerf/util/random.h"
#include "tests/nerf/losses/patch_loss_reference.h"
#include "tests/nerf/losses/patch_scene.h"
#include "tests/stability/double_compositing.h"
#include "tests/stability/loss_error.h"
#include "tests/stability/stability_case.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Geometry>

namespace structnerf {
namespace {

std::string MeasurePatchLoss(const int radius) {
  TexturedPlane plane;
  const Scene scene = MakeSlantedScene(&plane);
  const PatchSources sources = {{1, 2}, {0, 2}, {0, 1}};
  PatchLoss::Options options;
  options.radius = radius;
  LossError error;
  int num_compared = 0;
  int num_apart = 0;
  std::vector<double> gradient_errors;
  for (double depth = 1e-6; depth < 1e12; depth *= 1.7) {
    std::vector<PatchPixel> pixels;
    for (int row = 6; row < 30; row += 6) {
      for (int col = 6; col < 36; col += 6) {
        pixels.push_back({0, col, row});
      }
    }
    const PatchResult result =
        EvaluatePatches(scene,
                        sources,
                        options,
                        pixels,
                        std::vector<double>(pixels.size(), depth));
    for (size_t i = 0; i < pixels.size(); ++i) {
      const auto reference = [&](const double d) {
        return ReferencePatchLoss(
            scene, options, 0, sources[0], pixels[i].col, pixels[i].row, d);
      };
      RequireStable(
          std::isfinite(result.loss[i]) && std::isfinite(result.d_depth[i]),
          "a loss is not finite");
      const std::optional<double> expected = reference(depth);
      if (expected.has_value() != (result.num_valid[i] > 0)) {
        ++num_apart;  // a tap on the edge of its image
        continue;
      }
      if (!expected) {
        continue;
      }
      ++num_compared;
      error.value = std::max(error.value, std::abs(result.loss[i] - *expected));
      const double step = 1e-5 * depth;
      const auto above = reference(depth + step);
      const auto below = reference(depth - step);
      if (above && below) {
        gradient_errors.push_back(
            depth *
            std::abs(result.d_depth[i] - (*above - *below) / (2 * step)));
      }
    }
  }
  RequireStable(num_compared > 100, "too few patches compared");
  // Where a tap crosses from pixel to pixel the numeric slope is no measure.
  std::sort(gradient_errors.begin(), gradient_errors.end());
  error.gradient = gradient_errors[gradient_errors.size() * 95 / 100];
  return Accept(error,
                1e-4,
                5e-3,
                "; " + std::to_string(num_compared) + " patches, of " +
                    std::to_string(num_apart) + " only one says they are seen");
}

double PlanarLossInDouble(const PlanarGroup& group,
                          const std::vector<double>& depth) {
  double mean = 0;
  double difference = 1 / depth[3];
  for (int i = 0; i < 4; ++i) {
    mean += 0.25 / depth[i];
    difference -= i < 3 ? group.barycentric[i] / depth[i] : 0;
  }
  const double residual = std::abs(difference / mean);
  return residual < 0.01 ? 0.5 * residual * residual / 0.01 : residual - 0.005;
}

std::string MeasurePlanarLoss() {
  Random random(1);
  LossError error;
  const auto pixel = [&] { return 320 * random.NextFloat(); };
  for (double scale = 1e-20; scale < 1e20; scale *= 10) {
    for (int i = 0; i < 200; ++i) {
      PlanarGroup group;
      const float x[4] = {pixel(), pixel(), pixel(), pixel()};
      const float y[4] = {pixel(), pixel(), pixel(), pixel()};
      if (!MakePlanarGroup(x, y, &group)) {
        continue;
      }
      float depth[4];
      std::vector<double> depths;
      for (float& d : depth) {
        d = static_cast<float>(
            scale * std::pow(10.0, 4 * random.NextFloat() * (i % 2)) *
            (1 + 0.1 * random.NextFloat()));
        depths.push_back(d);
      }
      float d_depth[4];
      const double loss = EvaluatePlanarLoss(group, depth, d_depth);
      const double expected = PlanarLossInDouble(group, depths);
      error.value =
          std::max(error.value, std::abs(loss - expected) / (1 + expected));
      for (int k = 0; k < 4; ++k) {
        const double slope = Slope(
            [&](const double d) {
              std::vector<double> moved = depths;
              moved[k] = d;
              return PlanarLossInDouble(group, moved);
            },
            depths[k],
            1e-6 * depths[k]);
        error.gradient =
            std::max(error.gradient,
                     depths[k] * std::abs(d_depth[k] - slope) / (1 + expected));
      }
    }
  }
  return Accept(error, 1e-5, 1e-3);
}

// Volumes are cubic in depth, their derivatives quadratic.
std::string MeasureTripleProduct() {
  Random random(2);
  LossError error;
  for (double scale = 1e-10; scale < 1e10; scale *= 10) {
    for (int i = 0; i < 100; ++i) {
      Eigen::Vector3f directions[4];
      float depth[4];
      for (int k = 0; k < 4; ++k) {
        directions[k] = Eigen::Vector3f(
            2 * random.NextFloat() - 1, 2 * random.NextFloat() - 1, 1);
        depth[k] = static_cast<float>(scale * (1 + random.NextFloat()));
      }
      const auto loss = [&](const int moved, const double moved_depth) {
        Eigen::Vector3d points[4];
        for (int k = 0; k < 4; ++k) {
          points[k] =
              (k == moved ? moved_depth : static_cast<double>(depth[k])) *
              directions[k].cast<double>();
        }
        return std::abs((points[1] - points[0])
                            .cross(points[2] - points[0])
                            .dot(points[3] - points[0]));
      };
      float d_depth[4];
      const double value = EvaluateTripleProduct(directions, depth, d_depth);
      const double cube = std::pow(scale, 3);
      error.value = std::max(error.value, std::abs(value - loss(-1, 0)) / cube);
      if (value < 1e-4 * cube) {
        continue;  // at the kink of the absolute value
      }
      for (int k = 0; k < 4; ++k) {
        const double slope = Slope([&](const double d) { return loss(k, d); },
                                   depth[k],
                                   1e-6 * depth[k]);
        error.gradient = std::max(
            error.gradient, std::abs(d_depth[k] - slope) / (scale * scale));
      }
    }
  }
  return Accept(error, 1e-4, 1e-4);
}

// The pull of sparse points and the gradient by depth, through the compositing
// of a ray.
std::string MeasurePullThroughCompositing() {
  LossError error;
  for (const float raw : {-11.0f, -3.0f, 0.0f, 3.0f, 8.0f, 11.5f}) {
    for (const float pull_z : {1e-3f, 0.3f, 5.0f, 1e6f}) {
      for (const float d_depth : {0.0f, 1.0f}) {
        CompositeRays rays(/*num_rays=*/4, /*num_samples=*/24);
        Random random(5);
        for (size_t ray = 0; ray < rays.num_rays; ++ray) {
          float edge = 0.02f;
          for (size_t i = 0; i <= rays.num_samples; ++i) {
            rays.edges[ray * (rays.num_samples + 1) + i] = edge;
            edge += 0.08f * random.NextFloat();
          }
          for (size_t i = 0; i < rays.num_samples; ++i) {
            rays.raw_density[ray * rays.num_samples + i] =
                raw + 0.4f * (random.NextFloat() - 0.5f);
          }
        }
        const std::vector<float> gradient = CompositeGradient(
            rays, Composite(rays), d_depth, /*pull=*/1, pull_z);
        double largest = 0;
        double worst = 0;
        for (size_t i = 0; i < gradient.size(); ++i) {
          const size_t ray = i / rays.num_samples;
          CompositeRays moved = rays;
          const double step = 1.0 / 512;
          const auto loss = [&](const double value) {
            moved.raw_density[i] = static_cast<float>(value);
            return CompositeLossInDouble(moved, ray, d_depth, 1, pull_z);
          };
          const double value = rays.raw_density[i];
          const double high = static_cast<float>(value + step);
          const double low = static_cast<float>(value - step);
          const double slope = (loss(high) - loss(low)) / (high - low);
          largest = std::max(largest, std::abs(slope));
          worst = std::max(worst, std::abs(gradient[i] - slope));
        }
        // Below, float has nothing left of a loss of about one.
        error.gradient =
            std::max(error.gradient, worst / std::max(largest, 1e-6));
      }
    }
  }
  RequireStable(error.gradient < 1e-2, error.Text());
  return "gradients within " + ShortNumber(error.gradient) +
         " of double, relative to the largest of the ray";
}

}  // namespace

std::vector<StabilityCase> LossCases() {
  return {{"patch loss: depths of 1e-6 to 1e12",
           [] { return MeasurePatchLoss(PatchLoss::Options().radius); }},
          {"patch loss of single pixels: depths of 1e-6 to 1e12",
           [] { return MeasurePatchLoss(0); }},
          {"planar loss: depths of 1e-20 to 1e20", MeasurePlanarLoss},
          {"triple product: depths of 1e-10 to 1e10", MeasureTripleProduct},
          {"sparse loss through compositing: any density",
           MeasurePullThroughCompositing}};
}

}  // namespace structnerf
