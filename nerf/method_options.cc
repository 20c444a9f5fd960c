#include "nerf/method_options.h"

#include <variant>

namespace structnerf {
namespace {

std::vector<OptionEntry> FieldEntries(FieldOptions* field) {
  return {
      {"StructNeRF.field",
       &field->type,
       "{grid, mlp}: hash grid, or NeRF's networks (paper), some thousand "
       "times slower"},
      {"StructNeRF.num_levels",
       &field->num_levels,
       "Levels of the hash grid; -1 = from the scene",
       kFromScene,
       16},
      {"StructNeRF.log2_table_size",
       &field->log2_table_size,
       "Binary logarithm of the entries of a level; -1 = from the scene",
       kFromScene,
       24},
      {"StructNeRF.min_resolution",
       &field->min_resolution,
       "Cells along the scene's longest side, coarsest level",
       2,
       1024},
      {"StructNeRF.max_resolution",
       &field->max_resolution,
       "Cells along the scene's longest side, finest level; -1 = from the "
       "scene",
       kFromScene,
       65536},
      {"StructNeRF.hidden_width",
       &field->hidden_width,
       "Width of the hidden layers {16, 32, 48, 64}",
       16,
       64},
      {"StructNeRF.direction_degree",
       &field->direction_degree,
       "Degree of harmonics by which colour depends on the direction of view; "
       "0 = not",
       0,
       2},
      {"StructNeRF.mlp_num_layers",
       &field->mlp_num_layers,
       "Layers before density, mlp (paper: 8)",
       1,
       32},
      {"StructNeRF.mlp_width",
       &field->mlp_width,
       "Width of these layers (paper: 256)",
       2,
       1024},
      {"StructNeRF.latent_size",
       &field->latent_size,
       "Length of a latent code per photograph, mlp (paper's appendix: 48); "
       "0 = none",
       0,
       1024}};
}

std::vector<OptionEntry> SamplingEntries(SamplingOptions* sampling) {
  return {{"StructNeRF.num_bins",
           &sampling->num_bins,
           "Bins of cached density along a ray",
           8,
           256},
          {"StructNeRF.num_samples",
           &sampling->num_samples,
           "Samples of the field along a ray (paper: 64)",
           1,
           64},
          {"StructNeRF.num_fine_samples",
           &sampling->num_fine_samples,
           "Samples added for the fine network, mlp (paper: 128)",
           0,
           1024},
          {"StructNeRF.cache_resolution",
           &sampling->cache_resolution,
           "Cells of the density cache along the scene's longest side",
           8,
           512},
          {"StructNeRF.cache_interval",
           &sampling->cache_interval,
           "Steps between refreshes of the density cache",
           1,
           1000000},
          {"StructNeRF.cache_decay",
           &sampling->cache_decay,
           "How slowly the density cache forgets",
           0,
           0.999},
          {"StructNeRF.uniform_share",
           &sampling->uniform_share,
           "Share of the samples that is spread evenly along the ray",
           0,
           1},
          {"StructNeRF.guide_by_prior",
           &sampling->guide_by_prior,
           "Draw half of the training samples around the depth prior"},
          {"StructNeRF.bound_by_prior",
           &sampling->bound_by_prior,
           "Sample rays near the depth prior only"}};
}

std::vector<OptionEntry> LossEntries(LossOptions* loss) {
  return {{"StructNeRF.color_weight",
           &loss->color_weight,
           "Weight of the colour loss",
           0,
           1e6},
          {"StructNeRF.exposure",
           &loss->exposure,
           "Exposures that the colour loss gives photographs {none, affine, "
           "auto}; renders colours closer, not depth"},
          {"StructNeRF.patch_weight",
           &loss->patch_weight,
           "Weight of the patch photometric loss (paper: 0.025)",
           0,
           1e6},
          {"StructNeRF.patch_ssim_share",
           &loss->patch_ssim_share,
           "Share of SSIM in it, the rest is L1 (paper: 0.85)",
           0,
           1},
          {"StructNeRF.patch_radius",
           &loss->patch_radius,
           "Taps on either side of a patch's centre (paper: 1)",
           0,
           3},
          {"StructNeRF.patch_dilation",
           &loss->patch_dilation,
           "Pixels between taps (paper: 2); -1 = from the size of the images",
           kFromScene,
           16},
          {"StructNeRF.patch_sampling",
           &loss->patch_sampling,
           "Pixels that it is evaluated at {dense, keypoints}"},
          {"StructNeRF.source_selection",
           &loss->source_selection,
           "Which views are its sources {covisibility, neighbors} (paper: "
           "neighbors)"},
          {"StructNeRF.num_sources",
           &loss->num_sources,
           "Source views of each view (paper: 4)",
           1,
           32},
          {"StructNeRF.num_best_sources",
           &loss->num_best_sources,
           "Source views that count at a pixel",
           1,
           32},
          {"StructNeRF.planar_weight",
           &loss->planar_weight,
           "Weight of the planar loss (paper: 0.025)",
           0,
           1e6},
          {"StructNeRF.planar_form",
           &loss->planar_form,
           "{inverse_depth, triple_product} (paper: triple_product)"},
          {"StructNeRF.planar_min_area",
           &loss->planar_min_area,
           "Pixels of the full image from which a superpixel counts as planar "
           "(paper: 1000)",
           4,
           1 << 30},
          {"StructNeRF.sparse_weight",
           &loss->sparse_weight,
           "Weight of the depth of sparse points (paper: 0.05)",
           0,
           1e6},
          {"StructNeRF.sparse_form",
           &loss->sparse_form,
           "{line_of_sight, squared, kl} (paper: squared)"},
          {"StructNeRF.sparse_deviation",
           &loss->sparse_deviation,
           "Relative deviation that kl gives a point of mean error",
           1e-4,
           10},
          {"StructNeRF.sparse_fraction",
           &loss->sparse_fraction,
           "Share of the training in which it is used (paper: 0.5)",
           0,
           1},
          {"StructNeRF.prior_weight",
           &loss->prior_weight,
           "Initial weight of depth interpolated from sparse points",
           0,
           1e6},
          {"StructNeRF.prior_fraction",
           &loss->prior_fraction,
           "Share of the training after which it has faded out",
           0,
           1},
          {"StructNeRF.far_weight",
           &loss->far_weight,
           "Pull of blank pixels away from the camera",
           0,
           1e6},
          {"StructNeRF.dense_prior_weight",
           &loss->dense_prior_weight,
           "Weight of the likelihood of the depth priors of prior_path",
           0,
           1e6},
          {"StructNeRF.match_weight",
           &loss->match_weight,
           "Weight, in a second round of training, of depth that was matched "
           "and confirmed after a first one; 0 = one round only",
           0,
           1e6},
          {"StructNeRF.match_fraction",
           &loss->match_fraction,
           "Share of the training that the first round is",
           0.1,
           0.9}};
}

std::vector<OptionEntry> TrainingEntries(TrainingOptions* training) {
  return {
      {"StructNeRF.num_steps",
       &training->num_steps,
       "Training steps",
       1,
       100000000},
      {"StructNeRF.rays_per_step",
       &training->rays_per_step,
       "Rays per step",
       32,
       1 << 20},
      {"StructNeRF.max_image_size",
       &training->max_image_size,
       "Longest side in pixels of the images that are trained on",
       16,
       1 << 15},
      {"StructNeRF.grid_learning_rate",
       &training->grid_learning_rate,
       "Peak learning rate of the hash grid",
       0,
       1e3},
      {"StructNeRF.network_learning_rate",
       &training->network_learning_rate,
       "Peak learning rate of the networks",
       0,
       1e3},
      {"StructNeRF.final_learning_rate_factor",
       &training->final_learning_rate_factor,
       "Final learning rate divided by the peak",
       1e-6,
       1},
      {"StructNeRF.coarse_to_fine_fraction",
       &training->coarse_to_fine_fraction,
       "Share of the training in which finer grid levels come in",
       0,
       0.9},
      {"StructNeRF.stop_when_converged",
       &training->stop_when_converged,
       "Hasten to the end of the training once held-out pixels have settled"},
      {"StructNeRF.test_every",
       &training->test_every,
       "Keep every how many-th view out of training to measure PSNR; 0 = none",
       0,
       1 << 30},
      {"StructNeRF.latent_test",
       &training->latent_test,
       "Latent code of views that were kept out {zero, neighbors}"},
      {"StructNeRF.num_threads",
       &training->num_threads,
       "Threads; -1 = all cores"},
      {"StructNeRF.seed", &training->seed, "Seed of the training"}};
}

std::vector<OptionEntry> StereoEntries(StereoOptions* stereo) {
  return {
      {"StructNeRF.stereo_num_iterations",
       &stereo->num_iterations,
       "Sweeps of window matching over each view; 0 = keep the field's depth",
       0,
       100},
      {"StructNeRF.stereo_window_radius",
       &stereo->window_radius,
       "Half the side of its window in pixels",
       1,
       10},
      {"StructNeRF.stereo_window_step",
       &stereo->window_step,
       "Pixels between its taps",
       1,
       10},
      {"StructNeRF.stereo_num_used_sources",
       &stereo->num_used_sources,
       "Source views that a pixel is matched with",
       1,
       32},
      {"StructNeRF.stereo_num_best_sources",
       &stereo->num_best_sources,
       "Source views of these that count",
       1,
       32},
      {"StructNeRF.stereo_perturbation",
       &stereo->perturbation,
       "Relative random change of depth in the first sweep",
       0,
       1},
      {"StructNeRF.stereo_complete_planes",
       &stereo->complete_planes,
       "Put blank surfaces onto planes that several views agree on"}};
}

std::vector<OptionEntry> ExtractionEntries(ExtractionOptions* extraction) {
  return {{"StructNeRF.max_relative_std",
           &extraction->max_relative_std,
           "Largest deviation of depth along a ray, relative to it, of a pixel "
           "that is given a depth",
           0,
           1e6},
          {"StructNeRF.max_relative_depth_error",
           &extraction->max_relative_depth_error,
           "Largest relative depth difference of a confirming view",
           0,
           1},
          {"StructNeRF.max_reprojection_error",
           &extraction->max_reprojection_error,
           "Largest reprojection error of a confirming view, in pixels of maps "
           "of 640 pixels; more in larger ones, in proportion",
           0,
           1e6},
          {"StructNeRF.min_num_consistent",
           &extraction->min_num_consistent,
           "Views that must confirm a pixel of the geometric maps",
           1,
           1000},
          {"StructNeRF.min_triangulation_angle",
           &extraction->min_triangulation_angle,
           "Degrees between its ray and that of one of these views, where the "
           "scene offers as much",
           0,
           180},
          {"StructNeRF.averaging_num_views",
           &extraction->averaging_num_views,
           "Other views, at most, that matched depth is averaged over "
           "(0 = each view keeps its own)",
           0,
           1000},
          {"StructNeRF.averaging_max_depth_error",
           &extraction->averaging_max_depth_error,
           "Largest relative difference of depths that are averaged",
           0,
           1}};
}

// The error of a group of options as a sentence about "<prefix><field>".
template <typename Options>
std::string GroupError(const Options& options, const std::string& prefix) {
  std::string error;
  return options.Check(&error) ? "" : prefix + error;
}

}  // namespace

std::vector<OptionEntry> MakeMethodOptionEntries(
    ReconstructionOptions* options) {
  std::vector<OptionEntry> all_entries;
  for (const auto& entries : {FieldEntries(&options->field),
                              SamplingEntries(&options->sampling),
                              LossEntries(&options->loss),
                              TrainingEntries(&options->training),
                              StereoEntries(&options->stereo),
                              ExtractionEntries(&options->extraction)}) {
    all_entries.insert(all_entries.end(), entries.begin(), entries.end());
  }
  return all_entries;
}

ReconstructionOptions ChangePreset(ReconstructionOptions current,
                                   ReconstructionOptions preset,
                                   ReconstructionOptions new_preset) {
  const std::vector<OptionEntry> current_entries =
      MakeMethodOptionEntries(&current);
  const std::vector<OptionEntry> preset_entries =
      MakeMethodOptionEntries(&preset);
  const std::vector<OptionEntry> new_entries =
      MakeMethodOptionEntries(&new_preset);
  for (size_t i = 0; i < new_entries.size(); ++i) {
    if (current_entries[i].Value() == preset_entries[i].Value()) {
      continue;
    }
    std::visit(
        [&](auto* value) {
          *value = *std::get<decltype(value)>(current_entries[i].value);
        },
        new_entries[i].value);
  }
  return new_preset;
}

std::string FindMethodOptionError(const ReconstructionOptions& options) {
  for (const std::string& error :
       {GroupError(options.field, "StructNeRF."),
        GroupError(options.sampling, "StructNeRF."),
        GroupError(options.loss, "StructNeRF."),
        GroupError(options.training, "StructNeRF."),
        GroupError(options.stereo, "StructNeRF.stereo_"),
        GroupError(options.extraction, "StructNeRF.")}) {
    if (!error.empty()) {
      return error;
    }
  }
  return "";
}

}  // namespace structnerf
