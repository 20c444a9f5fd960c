#pragma once

#include <cstddef>
#include <string>

namespace structnerf {

// Options of one stage each. All fields are bool, int, double or std::string so
// that COLMAP's option manager can register them. Each Check() returns false
// and says in `error` which field is wrong and what is allowed.

// Of options that can be left to the scene, see nerf/analysis/scene_analysis.h.
constexpr int kFromScene = -1;

// The radiance field.
struct FieldOptions {
  // "grid": a multi-resolution hash grid (Mueller et al. 2022) decoded by small
  // networks; "mlp": NeRF's coarse and fine network (nerf/field/mlp_layout.h),
  // some thousand times slower.
  std::string type = "grid";

  // Number of grid levels, each with 8 features per entry; may be kFromScene.
  int num_levels = 4;

  // Binary logarithm of the most entries a level may have. Beyond it, grid
  // vertices share entries by hashing. May be kFromScene.
  int log2_table_size = 17;

  // Cells along the longest side of the scene box at the coarsest level.
  int min_resolution = 16;

  // Cells along the longest side at the finest level; may be kFromScene.
  int max_resolution = 768;

  // Width of the hidden layers: 16, 32, 48 or 64.
  int hidden_width = 32;

  // With "grid", the highest degree of the spherical harmonics of the viewing
  // direction that colour depends on, 0 to 2; 0 = colour is the same from all
  // sides.
  int direction_degree = 2;

  // Layers of each of NeRF's networks before density, and their width (NeRF: 8
  // and 256).
  int mlp_num_layers = 8;
  int mlp_width = 256;

  // Length of a latent code per photograph, beside the direction an input of
  // colour, with "mlp" (paper, appendix: 48); 0 = none.
  int latent_size = 0;

  bool Check(std::string* error) const;
};

// Where rays are sampled.
struct SamplingOptions {
  // Bins in which the cached density is read along each ray.
  int num_bins = 96;

  // Samples per ray at which the field is evaluated; with "mlp", the coarse
  // network (NeRF: 64).
  int num_samples = 16;

  // With "mlp", samples per ray that are added for the fine network (NeRF:
  // 128); 0 = the coarse network alone.
  int num_fine_samples = 128;

  // Cells of the density cache along the longest side of the scene box.
  int cache_resolution = 128;

  // Steps between refreshes of a part of the density cache.
  int cache_interval = 16;

  // How slowly a cell forgets a density that is no longer observed, in [0, 1):
  // see DensityCache::Observe.
  double cache_decay = 0.8;

  // Share of the samples that is spread evenly along the ray, whatever the
  // cache says. Few views need it large: a ray that only looks where it
  // believes the surface to be never learns that it is farther away, and the
  // scene collapses towards the cameras.
  double uniform_share = 0.5;

  // Half of the training samples of rays with a depth prior are drawn around
  // it.
  bool guide_by_prior = false;

  // Rays with a depth prior are sampled near it only
  // (nerf/train/prior_agreement.h), in training and rendering.
  bool bound_by_prior = false;

  bool Check(std::string* error) const;
};

// Terms of the objective. The paper's weights (0.025 patch, 0.025 planar, 0.05
// sparse) belong to 100 k steps and to losses that depend on the scene's scale;
// ours are free of scale and balanced for some thousand steps.
struct LossOptions {
  double color_weight = 1.0;

  // Whether the colour loss accounts for how photographs differ in exposure
  // (View::exposure): "none" takes all to be equal, "affine" does not, "auto"
  // only if they differ enough, which whoever makes the scene has to find out.
  // Accounting for it renders colours 0.5 to 1 dB closer to photographs and
  // depth, where surfaces are blank, slightly worse (nerf/EXPERIMENTS.md).
  std::string exposure = "none";

  // Patch photometric consistency with source views (paper, eq. 7-9).
  double patch_weight = 1.0;

  // Share of SSIM, the rest is L1 (paper: 0.85).
  double patch_ssim_share = 0.85;

  // Taps per patch side minus one, halved, and their distance in pixels of the
  // training image (paper: 1 and 2, i.e. 3x3 taps); or that is kFromScene.
  int patch_radius = 1;
  int patch_dilation = 2;

  // Where it is evaluated: at "dense" pixels or at "keypoints" only
  // (nerf/train/keypoints.h), the paper's ablation.
  std::string patch_sampling = "dense";

  // Which views are sources: by "covisibility", or the "neighbors" in the order
  // of the model (paper), see nerf/view_selection.h.
  std::string source_selection = "covisibility";

  // Source views per view, and how many of them (those that fit best) count at
  // a pixel. The others are taken to be occluded.
  int num_sources = 8;
  int num_best_sources = 4;

  // Coplanarity of pixels of one superpixel (paper, eq. 11).
  double planar_weight = 0.1;

  // "inverse_depth" (nerf/losses/planar_loss.h) or the paper's "triple_product"
  // (nerf/losses/triple_product.h), in units of the scene's median depth.
  std::string planar_form = "inverse_depth";

  // Area in pixels of the full-size image above which a superpixel is taken
  // for a plane (paper: 1000 at 0.29 megapixels).
  int planar_min_area = 1000;

  // Depth of the sparse points (paper, eq. 12-13).
  double sparse_weight = 1.0;

  // "line_of_sight", "squared" (paper) or "kl", see nerf/losses/sparse_loss.h.
  std::string sparse_form = "line_of_sight";

  // Standard deviation, relative to its depth, that "kl" gives a point of mean
  // reprojection error; others in proportion to theirs.
  double sparse_deviation = 0.02;

  // Share of the training after which the sparse term ends (paper: 0.5).
  double sparse_fraction = 0.5;

  // Depth interpolated from the sparse points of a view, for every pixel: the
  // weight at the start, falling linearly to zero at a share of the training.
  // It helps where points are all there is, and harms blank walls between
  // points that lie on other surfaces, so it is off unless asked for.
  double prior_weight = 0.0;
  double prior_fraction = 0.3;

  // Pull of blank pixels away from the camera (nerf/losses/far_push.h).
  double far_weight = 0.01;

  // Depth priors of the views (View::prior_depth), as their likelihood
  // (nerf/losses/depth_likelihood.h); for the whole training.
  double dense_prior_weight = 0.0;

  // Depth that matching has after a first round of training and that other
  // views confirm, as its likelihood in a second one, in which the field begins
  // anew. 0, or no matching (StereoOptions): there is only one round.
  double match_weight = 0.0;

  // Share of the training that the first round is.
  double match_fraction = 0.5;

  bool Check(std::string* error) const;
};

struct TrainingOptions {
  int num_steps = 1500;

  int rays_per_step = 1024;

  // Longest side of the images that are trained on, in pixels.
  int max_image_size = 320;

  // Peak learning rate of Adam for grid and networks. It falls
  // exponentially to `final_learning_rate_factor` of itself.
  double grid_learning_rate = 2e-2;
  double network_learning_rate = 4e-3;
  double final_learning_rate_factor = 0.1;

  // Share of the training, at most 0.9, during which finer grid levels come in
  // one after the other: coarse shape first, so that few views do not fit
  // noise.
  double coarse_to_fine_fraction = 0.2;

  // Whether training hastens to its end once pixels that were held out of it
  // have settled (nerf/train/convergence.h).
  bool stop_when_converged = false;

  // Every how many views one is kept out of training to measure PSNR; 0 = none.
  int test_every = 0;

  // The latent code of a view that was kept out: "zero", or the mean of its
  // "neighbors", the nearest views before and after it that were not.
  std::string latent_test = "zero";

  // -1 = all cores.
  int num_threads = -1;

  int seed = 0;

  bool Check(std::string* error) const;
};

// Matching of slanted windows, seeded by the field, at the end (nerf/stereo).
// Nothing holds a match near its seed, so that those of two views err
// independently and each can confirm the other. What no view confirms gets the
// field's depth back (ReplaceUnconfirmed in nerf/extract/consistency.h).
struct StereoOptions {
  // Sweeps over each view; 0 = leave the field's depth as it is.
  int num_iterations = 2;

  // Half the side of the window in pixels, and the distance of its taps.
  int window_radius = 5;
  int window_step = 2;

  // Sources that are used at a pixel, chosen by how well the seed fits, and how
  // many of them count.
  int num_used_sources = 5;
  int num_best_sources = 3;

  // Random changes of depth in the first sweep, relative; they halve from sweep
  // to sweep.
  double perturbation = 0.02;

  // Whether blank surfaces are put onto planes that several views agree on
  // (nerf/planes), once all views have been matched.
  bool complete_planes = true;

  bool Check(std::string* error) const;
};

// From the trained field to depth maps.
struct ExtractionOptions {
  // Pixels whose ray terminates less sharply are given no depth: largest
  // standard deviation of depth divided by depth.
  double max_relative_std = 0.5;

  // A view confirms a pixel if its own depth there agrees within this relative
  // difference and the pixel comes back within so many pixels of maps of 640
  // pixels; in larger maps within more, in proportion.
  double max_relative_depth_error = 0.02;
  double max_reprojection_error = 2.0;

  // Views that must confirm a pixel for the geometric maps; where depth is
  // averaged, confirmed depths that a pixel's mean must be of, its own among
  // them.
  int min_num_consistent = 2;

  // Degrees between the ray of a pixel of the geometric maps and that of at
  // least one view that confirms it (PatchMatch: 3, of every view). Less where
  // the scene offers less, see FitToScene in nerf/extract/consistency.h.
  double min_triangulation_angle = 4.0;

  // Where depth is matched, it is averaged over at most so many other views
  // (nerf/extract/depth_averaging.h): those that share most sparse points with
  // a view. 0 = over none.
  int averaging_num_views = 24;

  // Largest relative difference of depths that are of the same surface.
  double averaging_max_depth_error = 0.06;

  bool Check(std::string* error) const;
};

struct ReconstructionOptions {
  FieldOptions field;
  SamplingOptions sampling;
  LossOptions loss;
  TrainingOptions training;
  StereoOptions stereo;
  ExtractionOptions extraction;

  bool Check(std::string* error) const;

  // Whether anything asks for View::prior_depth.
  bool NeedsPrior() const;

  // Whether the field's depth is refined by matching.
  bool MatchesViews() const;

  // Whether depth is averaged over views, which needs matched depth: that of
  // the field has the same error in all of them.
  bool AveragesDepth() const;

  // Other views, at most, that depth is averaged over in a scene of so many.
  size_t NumAveragedViews(size_t num_views) const;

  // Whether the field learns from what is matched.
  bool LearnsFromMatches() const;

  // Whether blank surfaces are put onto planes, which needs matched depth.
  bool CompletesPlanes() const;
};

// The options, as far as they do not depend on the scene, of one of COLMAP's
// quality words, "low", "medium", "high" or
// "extreme", or of "paper": its own field, losses and schedule (section IV-C),
// which take days. Throws std::invalid_argument, listing them, for any other.
ReconstructionOptions QualityPreset(const std::string& quality);

}  // namespace structnerf
