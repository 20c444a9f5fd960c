// The matching of windows in photographs that it has nothing to hold on to.

#include "nerf/stereo/patch_match.h"
#include "tests/nerf/losses/patch_scene.h"
#include "tests/stability/simd_extremes.h"
#include "tests/stability/stability_case.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <vector>

namespace structnerf {
namespace {

// `value`: of a channel of a pixel in an image of the given number.
using PixelValue = std::function<uint8_t(int view_idx, size_t channel)>;

// Planes parallel to the image, `depth` away.
PlaneMaps MakeSeed(const View& view, const double depth) {
  PlaneMaps seed;
  seed.width = view.image.width;
  seed.height = view.image.height;
  const size_t num_pixels = static_cast<size_t>(seed.width) * seed.height;
  seed.rho.assign(num_pixels,
                  static_cast<float>(1 / (depth * MakePatchFrame().scale)));
  seed.rho_x.assign(num_pixels, 0.0f);
  seed.rho_y.assign(num_pixels, 0.0f);
  return seed;
}

std::string MeasureMatching(const PixelValue& value, const bool is_seed_kept) {
  TexturedPlane plane;
  Scene scene = MakeSlantedScene(&plane);
  for (size_t v = 0; v < scene.views.size(); ++v) {
    std::vector<uint8_t>& data = scene.views[v].image.data;
    for (size_t i = 0; i < data.size(); ++i) {
      data[i] = value(static_cast<int>(v), i);
    }
  }
  const SceneFrame frame = MakePatchFrame();
  const TrainingViews views(scene, frame);
  const PatchMatch patch_match(
      scene, frame, views, {{1, 2}, {0}, {0}}, StereoOptions());
  size_t num_seen = 0;
  double lowest_cost = 2;
  const double largest_change = WorstOfTargets([&] {
    double change = 0;
    for (const double depth : {1e-6, 4.0, 1e6}) {
      const PlaneMaps seed = MakeSeed(scene.views[0], depth);
      PlaneMaps maps = seed;
      ThreadPool pool(1);
      Progress progress;
      patch_match.Refine(0, &pool, &progress, &maps);
      RequireFinite(maps.rho_x, "a slope");
      RequireFinite(maps.rho_y, "a slope");
      RequireFinite(maps.distinctness, "a distinctness");
      for (size_t i = 0; i < maps.rho.size(); ++i) {
        RequireStable(maps.rho[i] > 0 && std::isfinite(maps.rho[i]),
                      "an inverse depth is " + ShortNumber(maps.rho[i]));
        RequireStable(maps.cost[i] > -1e-5f && maps.cost[i] <= 2,
                      "a cost is " + ShortNumber(maps.cost[i]));
        change =
            std::max<double>(change, std::abs(maps.rho[i] / seed.rho[i] - 1));
        if (maps.cost[i] < 2) {
          ++num_seen;
          lowest_cost = std::min<double>(lowest_cost, maps.cost[i]);
        }
      }
    }
    return change;
  });
  RequireStable(num_seen > 0, "no pixel was compared");
  RequireStable(
      !is_seed_kept || (largest_change == 0 && lowest_cost > 0.999),
      "depths without texture change by " + ShortNumber(largest_change));
  return "costs from " + ShortNumber(lowest_cost) + ", depths change by " +
         ShortNumber(largest_change) + " at most";
}

}  // namespace

std::vector<StabilityCase> StereoCases() {
  return {
      {"matching: black images",
       [] { return MeasureMatching([](int, size_t) { return 0; }, true); }},
      {"matching: white images",
       [] { return MeasureMatching([](int, size_t) { return 255; }, true); }},
      {"matching: each image of another single grey",
       [] {
         return MeasureMatching([](const int v, size_t) { return 90 * v; },
                                true);
       }},
      {"matching: one image black, one white, one striped",
       [] {
         return MeasureMatching(
             [](const int v, const size_t i) {
               return v == 2 ? 255 * (i / 3 % 2) : 255 * v;
             },
             false);
       }},
      {"matching: black and white noise", [] {
         return MeasureMatching(
             [](const int v, const size_t i) {
               return Random(v, i / 3, 0).NextBelow(2) * 255;
             },
             false);
       }}};
}

}  // namespace structnerf
