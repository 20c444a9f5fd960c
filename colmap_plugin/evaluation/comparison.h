#pragma once

#include "colmap_plugin/dense_workspace.h"
#include "colmap_plugin/evaluation/evaluator.h"
#include "colmap_plugin/evaluation/html_page.h"
#include "colmap_plugin/evaluation/map_agreement.h"
#include "colmap_plugin/run_progress.h"

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace structnerf {

// What the two workspaces are called.
constexpr std::array<const char*, 2> kLetters = {"A", "B"};

struct ComparisonOptions {
  // Dense workspaces of the same images, ours or PatchMatch's, A and B.
  std::array<std::string, 2> workspace_paths;

  // As in EvaluationOptions; `truth.path` empty = no truth.
  std::string image_path;
  std::string input_path;
  DepthTruthOptions truth;

  // Which maps: "geometric" or "photometric". If they are not in both
  // workspaces, the others are taken; if these are not either, each workspace
  // is taken with what it has.
  std::string map_type = "geometric";

  // Views that pictures are made of, evenly spread; 0 = all. Numbers are always
  // of all.
  int max_pictured_views = 30;

  // Longest side in pixels of the pictures.
  int picture_size = 320;

  // Throws std::runtime_error, naming the option, if one is wrong.
  void Check() const;
};

// One of the two workspaces.
struct ComparedWorkspace {
  std::string path;
  MapType map_type = MapType::kGeometric;
  size_t num_views = 0;

  // Mean over the common views of the share of pixels that have a depth; a
  // missing map counts as empty.
  double coverage = 0;

  std::optional<size_t> num_fused_points;

  // What its own report says; PatchMatch writes none.
  std::optional<double> seconds;
  std::optional<double> cpu_seconds;

  std::optional<Evaluation> evaluation;
};

struct ViewComparison {
  std::string name;
  std::array<double, 2> coverage{};
  MapAgreement agreement;  // at A's pixels, relative to A's depth

  // With truth: median of the absolute error, metres; nothing where there is no
  // truth or no prediction.
  std::array<std::optional<double>, 2> median_error;

  // Two rows of as many pictures, A's over B's (comparison_pictures.h); empty
  // if none are made of this view.
  std::vector<std::vector<HtmlPicture>> pictures;
};

struct Comparison {
  ComparisonOptions options;
  std::array<ComparedWorkspace, 2> workspaces;
  MapAgreement agreement;             // over all common views
  std::vector<ViewComparison> views;  // the common ones, by name

  // What the ends of the scales stand for, the same in all pictures.
  double nearest_depth = 0;       // units of A, or metres
  double farthest_depth = 0;      // likewise
  bool is_metric = false;         // depth is shown in metres
  double largest_error = 0;       // metres
  double largest_difference = 0;  // relative

  // Units of A per unit of B, from the poses.
  double a_per_b = 1;

  std::vector<std::string> notes;

  // Metres per unit of A if depth is shown in metres, else 1.
  double DisplayScale() const;
};

// Measures both workspaces and makes the pictures; nothing is written. Throws
// std::runtime_error if the workspaces have no image in common or something in
// them is wrong; Aborted if told to.
Comparison Compare(const ComparisonOptions& options, RunProgress* progress);

}  // namespace structnerf
