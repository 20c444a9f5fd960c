#pragma once

#include "nerf/losses/patch_loss.h"
#include "nerf/scene.h"
#include "nerf/scene_frame.h"
#include "tests/nerf/plane_scene.h"

#include <vector>

namespace structnerf {

using PatchSources = std::vector<std::vector<int>>;

struct PatchPixel {
  int view_idx = 0;
  int col = 0;
  int row = 0;
};

struct PatchResult {
  std::vector<float> loss;
  std::vector<float> d_depth;  // by depth in world units
  std::vector<int> num_valid;
};

// Field coordinates that are not the world's, so that a forgotten conversion
// shows.
SceneFrame MakePatchFrame();

// The patch loss of some pixels at depths in world units.
PatchResult EvaluatePatches(const Scene& scene,
                            const PatchSources& sources,
                            const PatchLoss::Options& options,
                            const std::vector<PatchPixel>& pixels,
                            const std::vector<double>& depths);

// Two views of 32 x 24 side by side, the second displaced so that what is one
// metre away has exactly `shift` pixels of disparity. They have no images yet.
Scene MakeStereoPair(double shift);

// Three views of a slanted textured wall with different cameras and sizes; the
// last one's image is half its camera's size.
Scene MakeSlantedScene(TexturedPlane* plane);

}  // namespace structnerf
