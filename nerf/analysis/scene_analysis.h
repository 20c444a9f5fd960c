#pragma once

#include "nerf/analysis/scene_decision.h"
#include "nerf/options.h"
#include "nerf/scene.h"
#include "nerf/scene_frame.h"

#include <vector>

namespace structnerf {

struct SceneAnalysis {
  // Nothing that they use is kFromScene.
  ReconstructionOptions options;

  SceneFrame frame;

  std::vector<SceneDecision> decisions;
};

// Chooses what the options leave to the scene (kFromScene), from its geometry:
//
// - field.max_resolution: a cell of the finest level is as large as 1.5 pixels
//   of the training images at the median depth of the sparse points. Much finer
//   cells hold what no photograph shows.
// - field.num_levels: from level to level, cells shrink to a quarter at most.
// - field.log2_table_size: one entry for four to eight cells that surfaces pass
//   through at the finest level. As many share one without harm, since coarser
//   levels tell them apart.
// - loss.patch_dilation: 3 pixels; in training images of more than 950 pixels,
//   in proportion to their size.
//
// Options that are given stay as they are. Photographs are not needed; if they
// are there, their size counts instead of training.max_image_size, and the
// share of planar superpixels is told from them. Throws std::invalid_argument
// if the scene has no extent, see ComputeSceneFrame.
SceneAnalysis AnalyzeScene(const Scene& scene,
                           const ReconstructionOptions& options);

}  // namespace structnerf
