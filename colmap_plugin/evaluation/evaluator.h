#pragma once

#include "colmap_plugin/dense_workspace.h"
#include "colmap_plugin/evaluation/cloud_evaluation.h"
#include "colmap_plugin/evaluation/depth_evaluation.h"
#include "colmap_plugin/evaluation/held_out_evaluation.h"
#include "colmap_plugin/evaluation/plane_evaluation.h"
#include "colmap_plugin/evaluation/reliability.h"
#include "colmap_plugin/run_progress.h"

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace structnerf {

struct EvaluationOptions {
  // Dense workspace, ours or PatchMatch's.
  std::string workspace_path;

  // The original images and their model, which the truth belongs to. Both
  // empty = the truth belongs to the workspace's undistorted images.
  std::string image_path;
  std::string input_path;

  // `truth.path` empty = no truth, only images are evaluated.
  DepthTruthOptions truth;
  CloudEvaluationOptions cloud;

  // Maps that are evaluated; nothing = both.
  std::optional<MapType> map_type;

  HeldOutOptions held_out;

  // Throws std::runtime_error, naming the option, if one is wrong.
  void Check() const;
};

struct MapEvaluation {
  DepthEvaluation depth;
  PlaneEvaluation planes;
};

struct Evaluation {
  EvaluationOptions options;

  SceneScale scale;
  size_t num_images_without_truth = 0;

  // "photometric", "geometric": the workspace's maps against the truth.
  std::map<std::string, MapEvaluation> maps;

  // Of the confidence of the photometric maps, in ours.
  std::optional<Reliability> confidence;

  // Of fused.ply.
  std::optional<CloudEvaluation> cloud;

  // Rendered from the field where it was not trained, and the depth of these
  // renderings against the truth.
  std::optional<HeldOutEvaluation> held_out;
  std::optional<MapEvaluation> held_out_depth;

  // What was left out, and why.
  std::vector<std::string> notes;
};

// Measures everything that workspace and options allow for. Throws
// std::runtime_error with one sentence about what is wrong, Aborted if told to.
Evaluation Evaluate(const EvaluationOptions& options, RunProgress* progress);

}  // namespace structnerf
