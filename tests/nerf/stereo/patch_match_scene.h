#pragma once

#include "nerf/stereo/patch_match.h"
#include "tests/nerf/losses/patch_scene.h"
#include "tests/nerf/simd_targets.h"

#include <cstddef>

namespace structnerf {

// Four views of a slanted wall; the last one's image is half its camera's size.
Scene MakeMatchedScene(TexturedPlane* plane);

// Of these views.
inline const PatchSources kAllSources = {{1, 2, 3}, {0}, {0}, {0}};

// The plane as a view sees it, in field units per pixel of its image.
PlaneMaps MakePlanes(const TexturedPlane& plane,
                     const View& view,
                     double scale);

// What matching the first view makes of a seed.
PlaneMaps RefinePlanes(const Scene& scene,
                       const PatchSources& sources,
                       const StereoOptions& options,
                       const PlaneMaps& seed,
                       int num_threads = 1);

// Bit for bit, but for what the planes cost.
bool SamePlanes(const PlaneMaps& a, const PlaneMaps& b);

// At pixel i.
bool SamePlane(const PlaneMaps& a, const PlaneMaps& b, size_t i);

// Share of the pixels at least `margin` away from the border whose depth is
// within a relative `tolerance` of the true one.
double ShareWithin(const PlaneMaps& maps,
                   const PlaneMaps& truth,
                   int margin,
                   double tolerance);

// Pixels whose window no photograph cuts off.
constexpr int kMargin = 6;

// Matching in MakeMatchedScene() from planes that are known.
class PatchMatchTest : public SimdTargetTest {
 protected:
  PatchMatchTest()
      : scene_(MakeMatchedScene(&plane_)),
        truth_(MakePlanes(plane_, scene_.views[0], MakePatchFrame().scale)) {}

  // The true planes, their depth off by a factor.
  PlaneMaps Seed(const float factor) const {
    PlaneMaps seed = truth_;
    for (size_t i = 0; i < seed.rho.size(); ++i) {
      seed.rho[i] *= factor;
      seed.rho_x[i] *= factor;
      seed.rho_y[i] *= factor;
    }
    return seed;
  }

  PlaneMaps RefineSeed(const PlaneMaps& seed, const int num_threads = 1) const {
    return RefinePlanes(scene_, kAllSources, options_, seed, num_threads);
  }

  TexturedPlane plane_;
  Scene scene_;
  PlaneMaps truth_;
  StereoOptions options_;
};

}  // namespace structnerf
